// Datagrams over a socketpair, never blocking.
#pragma once

#include <optional>

#include "gecos/base/bytes.hpp"
#include "gecos/base/descriptor.hpp"

namespace gecos::media {

struct SocketPair {
  Descriptor one;
  Descriptor other;
  /// Nothing when the kernel refuses: errno says why.
  static std::optional<SocketPair> open();
};

/// False when there is no room.
bool send_datagram(int socket, ByteView head, ByteView body);
bool has_datagram(int socket);
/// The next datagram, in `memory`.
std::optional<ByteView> receive_datagram(int socket, Bytes& memory);

}  // namespace gecos::media
