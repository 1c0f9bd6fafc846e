#pragma once

#include <cstdint>

#include "gecos/media/medium.hpp"

/// A way to send packets without waking a sleeping peer.
namespace gecos::media {

/// An interface of connections whose two ends read the same memory. Such a connection can send a
/// packet without waking a sleeping peer.
class QuietSender {
 public:
  /// Sends a packet like Connection::send, but without waking a sleeping peer. The peer reads the
  /// packet at its next poll, before any packet that wakes it. Only the thread that calls
  /// Connection::send may call this function. A packet that is stored outside the ring, and a
  /// packet after which less than half of the ring is free, do wake the peer, so that quiet packets
  /// do not fill the ring while the peer sleeps.
  virtual tl::expected<std::uint64_t, SendProblem> send_quietly(ByteView head, ByteView body) = 0;

 protected:
  ~QuietSender() = default;
};

/// Sends a packet for which the peer does not wait. Does not wake the peer if `connection` is a
/// QuietSender; otherwise sends the packet by Connection::send.
inline tl::expected<std::uint64_t, SendProblem> send_quietly(Connection& connection, ByteView head,
                                                             ByteView body) {
  if (auto* const quiet = dynamic_cast<QuietSender*>(&connection)) {
    return quiet->send_quietly(head, body);
  }
  return connection.send(head, body);
}

}  // namespace gecos::media
