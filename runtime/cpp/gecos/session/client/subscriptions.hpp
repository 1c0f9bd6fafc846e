#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>

#include "gecos/base/mutex.hpp"
#include "gecos/object.hpp"

namespace gecos::session {

class ClientConnection;
class ClientStream;

/// The subscriptions of one session to streams of its object. The server sends a stream until the
/// last subscription to it ends. Thread-safe.
class Subscriptions {
 public:
  explicit Subscriptions(ClientConnection& session) : session_(session) {}

  /// Subscribes to `stream` and waits until the samples of the stream can be read. `earlier`: see
  /// ClientStream.
  tl::expected<std::shared_ptr<ClientStream>, Failure> subscribe(
      const StreamDescription& stream, const ClientStream* earlier = nullptr);
  /// Returns whether the session is subscribed to a stream. Never blocks.
  bool any() const { return streams_.load(std::memory_order_relaxed) != 0; }
  /// Ends one subscription to `stream`. Never blocks.
  void unsubscribe(FunctionCode stream);

 private:
  tl::expected<std::shared_ptr<ClientStream>, Failure> open(const StreamDescription& stream,
                                                            CommandCore& subscribed,
                                                            const ClientStream* earlier);

  ClientConnection& session_;
  /// Held while a subscription is requested or ended, so that the end of one subscription does not
  /// end another subscription to the same stream. Must be locked before the mutex of CallSender.
  Mutex mutex_;
  /// The number of subscriptions of each stream.
  std::map<FunctionCode, std::size_t> counts_ GECOS_GUARDED_BY(mutex_);
  std::atomic<std::size_t> streams_{0};  // number of entries of counts_; orders no other memory
};

}  // namespace gecos::session
