#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "gecos/base/mutex.hpp"
#include "gecos/description.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {

/// Publishes one stream of an object. Creates one writer per medium, at the first subscription over
/// this medium. Without subscribers, only the latest sample is kept.
///
/// Publishing takes no lock of the object and uses no session. It does not allocate when a sample
/// of the same size was published before. Thread-safe.
class StreamPort {
 public:
  /// `object`: the name of the object, used in messages. Both arguments must outlive the port.
  StreamPort(const std::string& object, const StreamDescription& stream)
      : object_(object), stream_(stream) {}

  const StreamDescription& stream() const { return stream_; }
  void publish(ByteView sample, const SampleTime& time);
  /// Lets the client of `connection` read the stream under `id`. `acceptor`: the acceptor of
  /// `connection`. Fails with the reason.
  tl::expected<void, std::string> share(std::uint32_t id, media::Connection& connection,
                                        media::Acceptor& acceptor);
  /// Samples published from now on reach no client.
  void close();

 private:
  tl::expected<media::StreamWriter*, std::string> writer_for(media::Acceptor& acceptor)
      GECOS_REQUIRES(mutex_);
  std::string named() const;

  const std::string& object_;
  const StreamDescription& stream_;
  Mutex mutex_;
  std::map<std::string_view, std::unique_ptr<media::StreamWriter>> writers_
      GECOS_GUARDED_BY(mutex_);
  Bytes latest_ GECOS_GUARDED_BY(mutex_);  ///< as sent, with the measurement time appended
  std::int64_t latest_stamp_ns_ GECOS_GUARDED_BY(mutex_) = 0;
  bool published_ GECOS_GUARDED_BY(mutex_) = false;
  bool complained_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::session
