#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/parts/sample_buffer.hpp"
#include "gecos/media/parts/stream_ring.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/senders_clock.hpp"

namespace gecos::media {

/// The packets that have arrived for one end of a connection, stored by the thread that reads the
/// port. Packets are decrypted before they are stored, so that only those of the peer take room.
/// Thread-safe.
class ReceiveQueue final : public Sleeper {
 public:
  /// Packets beyond these bounds are dropped, as on a network: the sender notices the missing
  /// answer.
  static constexpr std::size_t most_bytes = 8 * 1024 * 1024;
  static constexpr std::size_t most_packets = 16 * 1024;

  /// Throws std::system_error when no descriptor is left.
  ReceiveQueue() = default;
  explicit ReceiveQueue(const crypto::Opener& opener) : opener_(opener) {}

  /// Sets the opener, which decrypts arriving packets; packets that arrive earlier are dropped.
  /// Must be called at most once.
  void open(const crypto::Opener& opener);
  /// Decrypts and stores a sealed datagram of the peer, read at `now`: its header, and the frame
  /// after it.
  void take(ByteView header, ByteView frame, TimePoint now);
  /// Stores a frame that was decrypted in place.
  void put(Bytes frame, TimePoint now);

  struct Packet {
    Bytes frame;       ///< a decrypted frame; packet_in() returns its packet
    TimePoint sent{};  ///< send time by our clock
  };
  /// Moves the next packet to `packet`, whose memory is reused. Returns false when there is none.
  bool pop(Packet& packet);
  static ByteView packet_in(const Bytes& frame);
  bool has_packets();
  std::optional<Duration> clock_difference();

  struct Notice {  // a message about a shared stream
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
  /// Must be called with every beat: deletes keys that were replaced.
  void on_tick(TimePoint now);

  /// Whether a packet was decrypted, which proves that the peer has the keys of the channel.
  bool heard() const { return beats() != 0; }
  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }
  /// As Connection::beats_read. The reader has handled a packet when it calls `pop` again.
  std::uint64_t beats_read() const { return beats_read_.load(std::memory_order_relaxed); }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  void set_asleep(bool asleep) { asleep_.store(asleep, std::memory_order_seq_cst); }
  void wake_if_asleep() override {
    if (asleep_.load(std::memory_order_seq_cst)) event_.notify();
  }
  EventFd& event() { return event_; }

 private:
  void put_locked(Bytes frame, TimePoint now) GECOS_REQUIRES(mutex_);
  void note(const InnerHeader& header, ByteView body) GECOS_REQUIRES(mutex_);
  void put_sample(const InnerHeader& header, ByteView body) GECOS_REQUIRES(mutex_);
  void note_read() GECOS_REQUIRES(mutex_);

  EventFd event_;
  std::atomic<bool> asleep_{false};  // tells the thread in pump() to notify event_
  std::atomic<bool> closed_{false};  // the peer has sent Bye
  std::atomic<std::uint64_t> beats_{0};
  std::atomic<std::uint64_t> beats_read_{0};
  std::atomic<std::uint64_t> dropped_{0};
  Mutex mutex_;
  std::optional<crypto::Opener> opener_ GECOS_GUARDED_BY(mutex_);
  SendersClock clock_ GECOS_GUARDED_BY(mutex_);
  std::deque<Packet> packets_ GECOS_GUARDED_BY(mutex_);
  /// The reader may still be handling the packet that it took last.
  bool in_hand_ GECOS_GUARDED_BY(mutex_) = false;
  /// Memory of a packet that was read; reused for the next frame.
  Bytes spare_ GECOS_GUARDED_BY(mutex_);
  std::size_t bytes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<Notice> notices_ GECOS_GUARDED_BY(mutex_);
  std::map<std::uint32_t, std::weak_ptr<SampleBuffer>> inward_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::media
