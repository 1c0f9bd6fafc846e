#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "gecos/media/bell.hpp"
#include "gecos/media/lcm/datagram.hpp"
#include "gecos/media/stream_ring.hpp"

namespace gecos::media {

/// What has arrived for one end of a link, put in by whoever pumps the port. Thread-safe.
class LcmInbox final : public Sleeper {
 public:
  /// More is dropped, as a network drops: whoever sends is told by the missing answer.
  static constexpr std::size_t most_bytes = 8 * 1024 * 1024;
  static constexpr std::size_t most_packets = 16 * 1024;

  /// Everything from the peer; `body` is what follows the header.
  void take(const DatagramHeader& header, ByteView body);
  /// The next packet, swapped into `into`.
  bool pop(Bytes& into);
  bool has_packets();

  struct Notice {  // anything but a packet or a beat
    DatagramKind kind{};
    std::uint64_t number = 0;
    SharedStream stream;
  };
  std::vector<Notice> notices();

  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  /// Which life of the server this client has heard; 0 before.
  std::uint64_t server() const { return server_.load(std::memory_order_relaxed); }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  void set_asleep(bool asleep) { asleep_.store(asleep, std::memory_order_seq_cst); }
  void wake_if_asleep() override {
    if (asleep_.load(std::memory_order_seq_cst)) ring_bell(bell_.descriptor());
  }
  Bell& bell() { return bell_; }

 private:
  Bell bell_;
  std::atomic<bool> asleep_{false};  // tells whoever pumps to ring
  std::atomic<bool> closed_{false};  // the peer said goodbye
  std::atomic<std::uint64_t> beats_{0};
  std::atomic<std::uint64_t> server_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::mutex mutex_;
  std::deque<Bytes> packets_;
  std::size_t bytes_ = 0;
  std::vector<Notice> notices_;
};

}  // namespace gecos::media
