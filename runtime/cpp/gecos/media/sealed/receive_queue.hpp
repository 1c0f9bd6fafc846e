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

/// The packets that have arrived for one end of a link, put in by the thread that pumps the port.
/// They are opened first, so that only packets of the peer count. Thread-safe.
class ReceiveQueue final : public Sleeper {
 public:
  /// Packets beyond these bounds are dropped, as on a network: the sender notices the missing
  /// answer.
  static constexpr std::size_t most_bytes = 8 * 1024 * 1024;
  static constexpr std::size_t most_packets = 16 * 1024;

  /// Throws std::system_error when no descriptor is left.
  ReceiveQueue() = default;
  explicit ReceiveQueue(const crypto::Opener& opener) : opener_(opener) {}

  /// From now on arriving packets can be opened; before, they are dropped. Must be called at most
  /// once.
  void open(const crypto::Opener& opener);
  /// Takes a sealed datagram of the peer, read at `now`: its header, and the frame after it.
  void take(ByteView header, ByteView frame, TimePoint now);
  /// A frame that was opened in place.
  void put(Bytes frame, TimePoint now);

  struct Packet {
    Bytes frame;       ///< opened; packet_in() says where in it the packet is
    TimePoint sent{};  ///< by our clock
  };
  /// The next packet. Reuses the memory of `packet`.
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
  /// From now on inward samples of `id` go to `samples`, as long as it exists.
  void collect(std::uint32_t id, std::weak_ptr<SampleBuffer> samples);
  /// Whether an inward sample has arrived that no reader and no earlier call has seen.
  bool new_samples();
  /// Called with every beat: deletes keys that were replaced.
  void on_tick(TimePoint now);

  /// True once a packet was opened: the peer has the channel's keys.
  bool heard() const { return beats() != 0; }
  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }
  /// As Link::beats_read. The reader has handled a packet when it calls `pop` again.
  std::uint64_t beats_read() const { return beats_read_.load(std::memory_order_relaxed); }
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
  void note_read();

  EventFd event_;
  std::atomic<bool> asleep_{false};  // tells the pumping thread to notify
  std::atomic<bool> closed_{false};  // the peer said goodbye
  std::atomic<std::uint64_t> beats_{0};
  std::atomic<std::uint64_t> beats_read_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::mutex mutex_;
  std::optional<crypto::Opener> opener_;
  SendersClock clock_;
  std::deque<Packet> packets_;
  bool in_hand_ = false;  // the reader may still be handling the packet that it took last
  Bytes spare_;           // of a packet that was taken: most frames need no memory of their own
  std::size_t bytes_ = 0;
  std::vector<Notice> notices_;
  std::map<std::uint32_t, std::weak_ptr<SampleBuffer>> inward_;
};

}  // namespace gecos::media
