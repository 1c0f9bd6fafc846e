#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/parts/sample_buffer.hpp"
#include "gecos/media/parts/stream_ring.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/senders_clock.hpp"

namespace gecos::media {

/// What has arrived for one end of a link, put in by whoever pumps the port: opened first, so that
/// nothing counts which is not the peer's. Thread-safe.
class ReceiveQueue final : public Sleeper {
 public:
  /// More is dropped, as a network drops: whoever sends is told by the missing answer.
  static constexpr std::size_t most_bytes = 8 * 1024 * 1024;
  static constexpr std::size_t most_packets = 16 * 1024;

  /// Throws std::system_error when no descriptor is left.
  ReceiveQueue() = default;
  explicit ReceiveQueue(const crypto::Opener& opener) : opener_(opener) {}

  /// From now on what arrives can be opened; before, it is dropped. Once.
  void open(const crypto::Opener& opener);
  /// A sealed datagram of the peer, read at `now`: its header, and the frame behind it.
  void take(ByteView header, ByteView frame, TimePoint now);
  /// A frame that was opened in place.
  void put(Bytes frame, TimePoint now);

  struct Packet {
    Bytes frame;       ///< opened; packet_in() says where in it the packet is
    TimePoint sent{};  ///< by our clock
  };
  /// The next packet. What `packet` held before is used again.
  bool pop(Packet& packet);
  static ByteView packet_in(const Bytes& frame);
  bool has_packets();
  std::optional<Duration> clock_difference();

  struct Notice {  // anything but a packet or a beat
    InnerKind kind{};
    std::uint64_t number = 0;
    SharedStream stream;
    InwardShare inward;
  };
  std::vector<Notice> notices();
  /// From now on inward samples of `id` go to `samples`, while somebody holds it.
  void collect(std::uint32_t id, std::weak_ptr<SampleBuffer> samples);
  /// Whether an inward sample came that nobody has seen.
  bool new_samples();
  /// With every beat: keys that were replaced go.
  void on_tick(TimePoint now);

  /// Something was opened: the peer has the channel's keys.
  bool heard() const { return beats() != 0; }
  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  void set_asleep(bool asleep) { asleep_.store(asleep, std::memory_order_seq_cst); }
  void wake_if_asleep() override {
    if (asleep_.load(std::memory_order_seq_cst)) event_.notify();
  }
  EventFd& event() { return event_; }

 private:
  void put_locked(Bytes frame, TimePoint now);
  void note(const InnerHeader& header, ByteView body);
  void put_sample(const InnerHeader& header, ByteView body);

  EventFd event_;
  std::atomic<bool> asleep_{false};  // tells whoever pumps to ring
  std::atomic<bool> closed_{false};  // the peer said goodbye
  std::atomic<std::uint64_t> beats_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::mutex mutex_;
  std::optional<crypto::Opener> opener_;
  SendersClock clock_;
  std::deque<Packet> packets_;
  Bytes spare_;  // of a packet that was taken: most frames need no memory of their own
  std::size_t bytes_ = 0;
  std::vector<Notice> notices_;
  std::map<std::uint32_t, std::weak_ptr<SampleBuffer>> inward_;
};

}  // namespace gecos::media
