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

/// Publishes one outward stream of an object, with a writer per medium from the first subscription
/// on. A stream without subscribers only keeps its latest sample.
///
/// Publishing takes no lock of the object, touches no session, and allocates nothing once a sample
/// of its size was published. Thread-safe.
class StreamPort {
 public:
  /// `object`: its name, for people. Both arguments outlive the port.
  StreamPort(const std::string& object, const StreamDescription& stream)
      : object_(object), stream_(stream) {}

  const StreamDescription& stream() const { return stream_; }
  void publish(ByteView sample, const SampleTime& time);
  /// Lets the client of `link`, which came through `acceptor`, read the stream as `id`. Fails with
  /// the reason.
  tl::expected<void, std::string> share(std::uint32_t id, media::Link& link,
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
  Bytes latest_ GECOS_GUARDED_BY(mutex_);  ///< as it is sent, with the time of measurement appended
  std::int64_t latest_stamp_ns_ GECOS_GUARDED_BY(mutex_) = 0;
  bool published_ GECOS_GUARDED_BY(mutex_) = false;
  bool complained_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::session
