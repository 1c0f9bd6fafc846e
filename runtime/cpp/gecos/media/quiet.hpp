#pragma once

#include <cstdint>

#include "gecos/media/medium.hpp"

/// Sending without waking the peer.
namespace gecos::media {

/// A link that can leave a sleeping peer asleep, because both ends read the same memory.
class QuietSender {
 public:
  /// Like Link::send, on the same thread, but a sleeping peer stays asleep: it reads the packet at
  /// its next poll, before any packet that wakes it. A packet stored beside the ring, and one that
  /// leaves the ring less than half free, wake the peer all the same, so that quiet packets never
  /// take the room of others.
  virtual tl::expected<std::uint64_t, SendProblem> send_quietly(ByteView head, ByteView body) = 0;

 protected:
  ~QuietSender() = default;
};

/// Sends a packet that ends no wait of the peer: quietly if `link` supports it, else by Link::send.
inline tl::expected<std::uint64_t, SendProblem> send_quietly(Link& link, ByteView head,
                                                             ByteView body) {
  if (auto* const quiet = dynamic_cast<QuietSender*>(&link)) return quiet->send_quietly(head, body);
  return link.send(head, body);
}

}  // namespace gecos::media
