#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "gecos/base/mutex.hpp"
#include "gecos/description.hpp"
#include "gecos/loan.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/sample_time.hpp"
#include "gecos/session/server/clear_sender.hpp"

namespace gecos::session {

/// Publishes one stream of an object. At the first subscription over a medium, creates the writer
/// for that medium. Before the first subscription, keeps the latest sample of a stream; does not
/// keep events.
///
/// A sample that is written in place is not copied, unless several media have readers: then each
/// other medium gets a copy.
///
/// `publish` locks no mutex of the object and uses no session. It allocates no memory when a sample
/// of the same size was published before. Thread-safe.
class StreamPort {
 public:
  /// `object`: the name of the object, used in messages. Both arguments must outlive the port.
  StreamPort(const std::string& object, const StreamDescription& stream)
      : object_(object), stream_(stream), clear_(stream.open_fingerprint.value_or(0)) {}

  const StreamDescription& stream() const { return stream_; }
  void publish(ByteView sample, const SampleTime& time);
  /// Lends memory of `size` bytes for the next sample. If a medium whose readers read samples in
  /// place has a subscription, lends memory of that medium. Otherwise lends private memory, and the
  /// sample is copied for each medium. Lends nothing after close(). Fails with the reason if the
  /// sample is too large, or while other memory of this stream is lent.
  tl::expected<LentMemory, std::string> lend(std::size_t size);
  /// Publishes the sample in `memory`, which lend() returned. Returns false if the stream was
  /// closed over the medium of this memory meanwhile.
  bool publish_lent(const LentMemory& memory, const SampleTime& time);
  /// Must be called when `memory`, which lend() returned, will not be published.
  void give_back(const LentMemory& memory);
  /// Returns how many samples and bytes were published. Does not set the member `readers`.
  StreamStats stats();
  /// Lets the client of `connection` read the stream under `id`. `acceptor`: the acceptor of
  /// `connection`. Returns the sequence number of the newest sample, 0 before the first one. On
  /// failure returns the reason.
  tl::expected<std::uint64_t, std::string> share(std::uint32_t id, media::Connection& connection,
                                                 media::Acceptor& acceptor);
  /// If the stream is an @open_stream and `acceptor` has channels for open streams, publishes all
  /// later samples in clear, too. Otherwise does nothing.
  void publish_in_clear(media::Acceptor& acceptor);
  /// Allows or forbids sending samples in clear. Returns true if this call changes the setting of
  /// an @open_stream; does nothing for other streams.
  bool allow_in_clear(bool allowed);
  /// Makes all later samples over `medium` unreadable for clients with whom the stream is no longer
  /// shared.
  void move_on(std::string_view medium);
  /// After this call, published samples reach no client.
  void close();

 private:
  struct Lent {
    const std::byte* first = nullptr;  ///< null if nothing is lent
    std::span<std::byte> whole{};      ///< the lent memory, with room for the measurement time
    /// The writer that lent the memory; null if the memory is `own`.
    media::StreamWriter* writer = nullptr;
    std::shared_ptr<Bytes> own{};  ///< private memory, which later loans use again
  };

  /// Returns the latest sample with its measurement time. @pre `kept_` is true
  ByteView latest() const GECOS_REQUIRES(mutex_);
  void count(std::size_t size) GECOS_REQUIRES(mutex_);
  /// Publishes the latest sample over all media except the medium of the writer `written`.
  void distribute(const media::StreamWriter* written) GECOS_REQUIRES(mutex_);
  void end_loan() GECOS_REQUIRES(mutex_);
  void forget(const media::StreamWriter* ended) GECOS_REQUIRES(mutex_);
  tl::expected<media::StreamWriter*, std::string> writer_for(media::Acceptor& acceptor)
      GECOS_REQUIRES(mutex_);
  /// Returns the number of the newest sample; 0 when there is no sample yet.
  std::uint64_t newest_number() const GECOS_REQUIRES(mutex_);
  void drop(std::size_t size, std::string_view medium) GECOS_REQUIRES(mutex_);
  std::string named() const;

  const std::string& object_;
  const StreamDescription& stream_;
  FutexMutex mutex_;
  std::map<std::string_view, std::unique_ptr<media::StreamWriter>> writers_
      GECOS_GUARDED_BY(mutex_);
  /// Like the writers of the media, `clear_` sends while the mutex is held, so that the samples of
  /// several publishing threads leave in the order of their numbers. Has channels for an
  /// @open_stream only.
  ClearSender clear_ GECOS_GUARDED_BY(mutex_);
  /// The latest sample, with the measurement time appended.
  Bytes latest_ GECOS_GUARDED_BY(mutex_);
  /// The writer whose memory contains the latest sample, if that sample was written in place; null
  /// if `latest_` contains the latest sample.
  media::StreamWriter* latest_in_ GECOS_GUARDED_BY(mutex_) = nullptr;
  Lent lent_ GECOS_GUARDED_BY(mutex_);
  std::int64_t latest_stamp_ns_ GECOS_GUARDED_BY(mutex_) = 0;
  bool kept_ GECOS_GUARDED_BY(mutex_) = false;  ///< the latest sample is kept for later subscribers
  bool closed_ GECOS_GUARDED_BY(mutex_) = false;
  bool complained_ GECOS_GUARDED_BY(mutex_) = false;
  std::uint64_t samples_ GECOS_GUARDED_BY(mutex_) = 0;
  std::uint64_t bytes_ GECOS_GUARDED_BY(mutex_) = 0;    ///< total size of the values of all samples
  std::uint64_t dropped_ GECOS_GUARDED_BY(mutex_) = 0;  ///< samples too large for a medium
};

}  // namespace gecos::session
