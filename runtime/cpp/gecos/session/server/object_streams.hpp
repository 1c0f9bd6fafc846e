#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/session/server/stream_port.hpp"

namespace gecos::session {

/// The outward streams of one object, each with a port of its own. Thread-safe.
class ObjectStreams {
 public:
  ObjectStreams(std::string object, const InterfaceDescription& interface);

  /// Clients of this acceptor may subscribe.
  void offer(std::shared_ptr<media::Acceptor> acceptor);
  /// Samples published from now on reach no client.
  void close();
  /// Shares the stream with the client of `link`. Returns the id of the stream on that link.
  tl::expected<std::uint32_t, std::string> share(const StreamDescription& stream,
                                                 media::Link& link);
  /// Ignores a stream that the interface does not have.
  void publish(const StreamDescription& stream, ByteView sample, const SampleTime& time);

 private:
  /// The number of ports when the interface has no such stream.
  std::size_t index_of(const StreamDescription& stream) const;

  const std::string object_;
  std::vector<std::unique_ptr<StreamPort>> ports_;  ///< by code; never changes
  Mutex mutex_;
  std::map<std::string_view, std::shared_ptr<media::Acceptor>> acceptors_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
