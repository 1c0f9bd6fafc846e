#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "gecos/base/mutex.hpp"
#include "gecos/description.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {

/// Publishes one stream of an object. At the first subscription over a medium, creates the writer
/// for that medium. Until the first subscription, keeps the latest sample of a stream, but no
/// event.
///
/// `publish` locks no mutex of the object and uses no session. It allocates no memory when a sample
/// of the same size was published before. Thread-safe.
class StreamPort {
 public:
  /// `object`: the name of the object, used in messages. Both arguments must outlive the port.
  StreamPort(const std::string& object, const StreamDescription& stream)
      : object_(object), stream_(stream) {}

  const StreamDescription& stream() const { return stream_; }
  void publish(ByteView sample, const SampleTime& time);
  /// Returns how much was published. Does not set `readers`.
  StreamStats stats();
  /// Lets the client of `connection` read the stream under `id`. `acceptor`: the acceptor of
  /// `connection`. Returns the sequence number of the newest sample, 0 before the first one. On
  /// failure returns the reason.
  tl::expected<std::uint64_t, std::string> share(std::uint32_t id, media::Connection& connection,
                                                 media::Acceptor& acceptor);
  /// Publishes all later samples of an @open_stream in clear, too, if `acceptor` has channels for
  /// that. Does nothing for other streams.
  void publish_in_clear(media::Acceptor& acceptor);
  /// Makes all later samples over `medium` unreadable for clients with whom the stream is no longer
  /// shared.
  void move_on(std::string_view medium);
  /// After this call, published samples reach no client.
  void close();

 private:
  tl::expected<media::StreamWriter*, std::string> writer_for(media::Acceptor& acceptor)
      GECOS_REQUIRES(mutex_);
  /// Returns the number of the newest sample; 0 when no medium has one.
  std::uint64_t newest_number() const GECOS_REQUIRES(mutex_);
  void send_in_clear(ByteView sample) GECOS_REQUIRES(mutex_);
  void drop(std::size_t size, std::string_view medium) GECOS_REQUIRES(mutex_);
  std::string named() const;

  const std::string& object_;
  const StreamDescription& stream_;
  Mutex mutex_;
  std::map<std::string_view, std::unique_ptr<media::StreamWriter>> writers_
      GECOS_GUARDED_BY(mutex_);
  std::map<std::string_view, std::unique_ptr<media::OpenChannel>> open_channels_
      GECOS_GUARDED_BY(mutex_);  ///< by medium; of an @open_stream only
  Bytes open_message_ GECOS_GUARDED_BY(mutex_);
  Bytes latest_ GECOS_GUARDED_BY(mutex_);  ///< the latest sample, with the measurement time
                                           ///< appended
  std::int64_t latest_stamp_ns_ GECOS_GUARDED_BY(mutex_) = 0;
  bool kept_ GECOS_GUARDED_BY(mutex_) = false;  ///< `latest_` is for readers that come later
  bool complained_ GECOS_GUARDED_BY(mutex_) = false;
  std::uint64_t samples_ GECOS_GUARDED_BY(mutex_) = 0;
  std::uint64_t bytes_ GECOS_GUARDED_BY(mutex_) = 0;    ///< of the values of all samples
  std::uint64_t dropped_ GECOS_GUARDED_BY(mutex_) = 0;  ///< samples too large for a medium
};

}  // namespace gecos::session
