#pragma once

#include <cstdint>

#include "gecos/media/medium.hpp"

/// Sends packets without waking a sleeping peer.
namespace gecos::media {

/// A connection that can leave a sleeping peer asleep, because both ends read the same memory.
class QuietSender {
 public:
  /// Like Connection::send, and called by the same thread, but without waking a sleeping peer: the
  /// peer reads the packet at its next poll, before any packet that wakes it. A packet stored
  /// outside the ring, or one that leaves less than half of the ring free, wakes the peer
  /// nevertheless, so that quiet packets do not fill the ring while the peer sleeps.
  virtual tl::expected<std::uint64_t, SendProblem> send_quietly(ByteView head, ByteView body) = 0;

 protected:
  ~QuietSender() = default;
};

/// Sends a packet for which the peer does not wait: without waking the peer if `connection`
/// supports that, else by Connection::send.
inline tl::expected<std::uint64_t, SendProblem> send_quietly(Connection& connection, ByteView head,
                                                             ByteView body) {
  if (auto* const quiet = dynamic_cast<QuietSender*>(&connection)) {
    return quiet->send_quietly(head, body);
  }
  return connection.send(head, body);
}

}  // namespace gecos::media
