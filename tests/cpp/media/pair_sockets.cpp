#include "pair_sockets.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <array>

#include "pair_medium.hpp"

namespace gecos::media {

std::optional<SocketPair> SocketPair::open() {
  std::array<int, 2> both{-1, -1};
  if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, both.data()) != 0) {
    return std::nullopt;
  }
  return SocketPair{Descriptor(both[0]), Descriptor(both[1])};
}

bool send_datagram(int socket, ByteView head, ByteView body) {
  const auto piece = [](ByteView bytes) {
    return iovec{const_cast<std::byte*>(bytes.data()), bytes.size()};
  };
  std::array pieces{piece(head), piece(body)};
  msghdr message{};
  message.msg_iov = pieces.data();
  message.msg_iovlen = pieces.size();
  return ::sendmsg(socket, &message, MSG_NOSIGNAL) >= 0;
}

bool has_datagram(int socket) {
  std::byte first{};
  return ::recv(socket, &first, sizeof first, MSG_PEEK) >= 0;
}

std::optional<ByteView> receive_datagram(int socket, Bytes& memory) {
  memory.resize(pair_datagram);
  const ssize_t size = ::recv(socket, memory.data(), memory.size(), 0);
  if (size < 0) return std::nullopt;
  return ByteView(memory).first(static_cast<std::size_t>(size));
}

}  // namespace gecos::media
