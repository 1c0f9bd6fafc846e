#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/server/stream_port.hpp"

namespace gecos::session {

/// The streams that one object publishes, each with its own StreamPort. Thread-safe.
class ObjectStreams {
 public:
  ObjectStreams(std::string object, const InterfaceDescription& interface);

  /// Allows clients that connect through `acceptor` to subscribe, and publishes the open streams on
  /// the open channels of `acceptor`.
  void offer(std::shared_ptr<media::Acceptor> acceptor);
  /// Allows or forbids sending the samples of open streams in clear; at first it is allowed.
  /// Returns true if this call changes the setting of at least one open stream.
  bool allow_in_clear(bool allowed);
  /// After this call, published samples reach no client.
  void close();
  /// Lets the client of `connection` read the stream. Returns the id of the stream on that
  /// connection, and the sequence number of the newest sample.
  tl::expected<Subscription, std::string> share(const StreamDescription& stream,
                                                media::Connection& connection);
  /// Ends all subscriptions of the client of `connection`, and makes all later samples unreadable
  /// for this client.
  void exclude(media::Connection& connection);
  /// Publishes `sample`. Does nothing when the interface has no such stream.
  void publish(const StreamDescription& stream, ByteView sample, const SampleTime& time);
  /// Lends memory for the next sample, like StreamPort::lend().
  tl::expected<LentMemory, std::string> lend(const StreamDescription& stream, std::size_t size);
  bool publish_lent(const StreamDescription& stream, const LentMemory& memory,
                    const SampleTime& time);
  void give_back(const StreamDescription& stream, const LentMemory& memory);
  /// Returns how many samples and bytes were published on each stream. The streams are in the order
  /// of their ids on the connections. Does not set the member `readers`.
  std::vector<StreamStats> stats() const;

 private:
  /// Returns the index of the port of `stream`; the number of ports when the interface has no such
  /// stream.
  std::size_t index_of(const StreamDescription& stream) const;

  const std::string object_;
  std::vector<std::unique_ptr<StreamPort>> ports_;  ///< sorted by stream code; constant
  Mutex mutex_;
  std::map<std::string_view, std::shared_ptr<media::Acceptor>> acceptors_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
