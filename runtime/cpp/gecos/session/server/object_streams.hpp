#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/description.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {

/// The outward streams of one object: a writer per medium and stream from the first subscription
/// on. Publishing a stream that nobody ever subscribed to only keeps its latest sample.
class ObjectStreams {
 public:
  ObjectStreams(std::string object, const InterfaceDescription& interface);

  /// Clients of this acceptor may subscribe.
  void offer(std::shared_ptr<media::Acceptor> acceptor);
  /// What is published from now on reaches nobody.
  void close();
  /// A client came by this link's medium: shares the stream with it. Gives the id it has there.
  tl::expected<std::uint32_t, std::string> share(const StreamDescription& stream,
                                                 media::Link& link);
  void publish(const StreamDescription& stream, ByteView sample, const SampleTime& time);

 private:
  struct Outlet {
    std::map<media::Kind, std::unique_ptr<media::StreamWriter>> writers;
    Bytes latest;  ///< as it travels
    std::int64_t latest_stamp_ns = 0;
    bool published = false;
    bool complained = false;
  };

  const std::string object_;
  const std::vector<const StreamDescription*> streams_;  ///< of the interface, by code
  Mutex mutex_;
  std::map<media::Kind, std::shared_ptr<media::Acceptor>> acceptors_ GECOS_GUARDED_BY(mutex_);
  std::vector<Outlet> outlets_ GECOS_GUARDED_BY(mutex_);  ///< one for each of them
};

}  // namespace gecos::session
