#include "gecos/media/lcm/receiver.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/crypto/big_endian.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t largest_datagram = 64 * 1024;
constexpr std::uint64_t magic_of_small = 0x4c433032;  // "LC02"; fragments begin with "LC03"
constexpr std::size_t numbers_size = 8;               // bytes of magic and sequence number

template <class T>
bool set(int socket, int level, int option, const T& value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

/// Logs a warning when the receive buffer of `socket` is smaller than `wanted` bytes, but only once
/// per process.
void warn_of_small_buffer(int socket, int wanted) {
  int doubled = 0;  // the kernel reports twice the usable size
  socklen_t size = sizeof doubled;
  if (::getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &doubled, &size) != 0 || doubled / 2 >= wanted) {
    return;
  }
  static std::atomic<bool> said{false};  // orders no other memory
  if (said.exchange(true)) return;
  log_warning("lcm", "the receive buffer holds only " + std::to_string(doubled / 2) +
                         " bytes, and packets that do not fit are lost; run as root:  "
                         "sysctl -w net.core.rmem_max=" +
                         std::to_string(wanted));
}

MediumError cannot_hear(const LcmOptions& options, std::uint16_t port) {
  const int problem = errno;
  const std::string what = "lcm: cannot receive from " + options.group + ":" +
                           std::to_string(port) + ": " + system_text(problem);
  if (problem == EMFILE || problem == ENFILE) return {what};
  return {what + multicast_advice(options)};
}

}  // namespace

std::string multicast_advice(const LcmOptions& options) {
  return " (no multicast route? run as root:  ip link set lo multicast on && ip route add " +
         options.group + "/32 dev " + (options.ttl == 0 ? "lo" : "<the network's interface>") + ")";
}

std::optional<LcmMessage> LcmMessage::read(ByteView datagram) {
  if (datagram.size() <= numbers_size ||
      crypto::read_u64(datagram.first<8>()) >> 32 != magic_of_small) {
    return std::nullopt;
  }
  const ByteView named = datagram.subspan(numbers_size);
  const auto end = std::ranges::find(named, std::byte{0});
  if (end == named.end()) return std::nullopt;
  const auto length = static_cast<std::size_t>(end - named.begin());
  return LcmMessage{{reinterpret_cast<const char*>(named.data()), length},
                    named.subspan(length + 1)};
}

LcmReceiver::LcmReceiver(Descriptor socket)
    : socket_(std::move(socket)), memory_(new std::byte[largest_datagram]) {}

tl::expected<LcmReceiver, MediumError> LcmReceiver::open(const LcmOptions& options,
                                                         std::uint16_t port) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(port);
  if (::inet_pton(AF_INET, options.group.c_str(), &place.sin_addr) != 1) errno = EINVAL;
  const ip_mreq membership{place.sin_addr, {htonl(INADDR_ANY)}};
  Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  // The socket is bound to the address of the multicast group, so that it receives no unicast
  // packets.
  if (!socket || !set(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1) ||
      ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0 ||
      !set(socket.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, membership)) {
    return tl::unexpected(cannot_hear(options, port));
  }
  set(socket.get(), SOL_SOCKET, SO_RCVBUF, options.receive_buffer_bytes);
  warn_of_small_buffer(socket.get(), options.receive_buffer_bytes);
  return LcmReceiver(std::move(socket));
}

std::optional<LcmMessage> LcmReceiver::next() {
  for (;;) {
    const ssize_t size = ::recv(socket_.get(), memory_.get(), largest_datagram, MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return std::nullopt;
    if (auto message = LcmMessage::read({memory_.get(), static_cast<std::size_t>(size)}))
      return message;
  }
}

}  // namespace gecos::media
