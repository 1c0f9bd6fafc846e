#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/buffers/sample_buffer.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/senders_clock.hpp"

namespace gecos::media {

/// The packets that have arrived for one end of a connection. The thread that reads the port stores
/// them here. Packets are decrypted before they are stored, so that only packets of the peer take
/// memory. Thread-safe.
class ReceiveQueue final : public Sleeper {
 public:
  /// The limits of the queue. A packet that would exceed a limit is dropped, as if the network had
  /// lost it; the sender notices that there is no answer.
  static constexpr std::size_t most_bytes = 8 * 1024 * 1024;
  static constexpr std::size_t most_packets = 16 * 1024;

  /// Throws std::system_error when the process cannot open another file descriptor.
  ReceiveQueue() = default;
  explicit ReceiveQueue(const crypto::Opener& opener) : opener_(opener) {}

  /// Sets the opener, which decrypts the packets that arrive. Packets that arrive before this call
  /// are dropped. Must be called at most once.
  void open(const crypto::Opener& opener);
  /// Decrypts and stores a sealed datagram that was read from the port at the time `now`. The
  /// datagram consists of `header` and `frame`.
  void take(ByteView header, ByteView frame, TimePoint now);
  /// Stores a frame that the caller has decrypted in place.
  void put(Bytes frame, TimePoint now);

  struct Packet {
    Bytes frame;       ///< a decrypted frame; packet_in() returns its packet
    TimePoint sent{};  ///< send time by our clock
  };
  /// Moves the next packet to `packet`, whose memory the queue uses again. Returns false when there
  /// is no packet.
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
  /// Makes the queue put the samples of the client's stream `id` into `samples` from now on, as
  /// long as `samples` exists.
  void collect(std::uint32_t id, std::weak_ptr<SampleBuffer> samples);
  /// Returns whether a sample of a client's stream has arrived that neither its reader nor an
  /// earlier call has seen.
  bool new_samples();
  /// Deletes keys that were replaced. Must be called with every heartbeat.
  void on_tick(TimePoint now);

  /// Returns whether a packet was decrypted. This proves that the peer has the keys of the channel.
  bool heard() const { return beats() != 0; }
  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }
  /// Returns the value of Connection::beats_read. A packet that `pop` has returned counts as read
  /// when the reader calls `pop` again.
  std::uint64_t beats_read() const { return beats_read_.load(std::memory_order_relaxed); }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  /// Returns why the server has refused this client. The text is empty while the server has not
  /// refused the client.
  std::string refusal();
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
  /// True when the reader may still be handling the packet that it took last.
  bool in_hand_ GECOS_GUARDED_BY(mutex_) = false;
  /// The memory of a packet that was read, kept for the next packet.
  Bytes spare_ GECOS_GUARDED_BY(mutex_);
  std::size_t bytes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::string refusal_ GECOS_GUARDED_BY(mutex_);
  std::vector<Notice> notices_ GECOS_GUARDED_BY(mutex_);
  std::map<std::uint32_t, std::weak_ptr<SampleBuffer>> inward_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::media
