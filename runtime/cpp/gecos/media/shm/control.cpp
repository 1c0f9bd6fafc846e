#include "gecos/media/shm/control.hpp"

#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <type_traits>

#include "gecos/base/system_error.hpp"
#include "gecos/base/whole_characters.hpp"

namespace gecos::media::shm {
namespace {

static_assert(std::is_trivially_copyable_v<ControlMessage>);

constexpr std::uint32_t nobody = 65534;  // the uid of users that do not exist in this namespace
constexpr int so_peerpidfd = 77;         // SO_PEERPIDFD of Linux 6.5, not in older headers

union alignas(cmsghdr) DescriptorSpace {
  char bytes[CMSG_SPACE(2 * sizeof(int))];
};

/// Takes ownership of all descriptors of a received message. Returns false when the message has
/// more descriptors than allowed, or when some descriptors were lost.
bool take_descriptors(msghdr& header, std::array<Descriptor, 2>& into) {
  std::size_t taken = 0;
  bool fits = (header.msg_flags & MSG_CTRUNC) == 0;
  for (cmsghdr* at = CMSG_FIRSTHDR(&header); at != nullptr; at = CMSG_NXTHDR(&header, at)) {
    if (at->cmsg_level != SOL_SOCKET || at->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (at->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(at) + i * sizeof(int), sizeof fd);
      Descriptor owned(fd);
      if (taken < into.size()) {
        into[taken++] = std::move(owned);
      } else {
        fits = false;
      }
    }
  }
  return fits;
}

}  // namespace

void ControlMessage::set_text(std::string_view words) {
  text.fill('\0');
  std::ranges::copy(whole_characters(words, text.size() - 1), text.begin());
}

std::string ControlMessage::words() const {
  return {text.begin(), std::find(text.begin(), text.end(), '\0')};
}

bool send_control(int socket, const ControlMessage& message, std::span<const int> descriptors) {
  iovec piece{const_cast<ControlMessage*>(&message), sizeof message};
  msghdr header{};
  header.msg_iov = &piece;
  header.msg_iovlen = 1;
  DescriptorSpace space{};
  if (!descriptors.empty()) {
    header.msg_control = space.bytes;
    header.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* const first = CMSG_FIRSTHDR(&header);
    first->cmsg_level = SOL_SOCKET;
    first->cmsg_type = SCM_RIGHTS;
    first->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(first), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(sizeof message);
}

ControlRead receive_control(int socket, ReceivedControl& into) {
  iovec piece{&into.message, sizeof into.message};
  msghdr header{};
  header.msg_iov = &piece;
  header.msg_iovlen = 1;
  DescriptorSpace space{};
  header.msg_control = space.bytes;
  header.msg_controllen = sizeof space.bytes;
  ssize_t got = -1;
  do {
    got = ::recvmsg(socket, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    // The kernel reports ECONNRESET once, before the data that the peer sent earlier. Therefore the
    // loop reads again to get that data.
  } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
  if (got < 0) {
    return errno == EAGAIN || errno == EWOULDBLOCK ? ControlRead::Nothing : ControlRead::Ended;
  }
  into.descriptors = {};
  const bool fits = take_descriptors(header, into.descriptors);
  if (got == 0) return ControlRead::Ended;
  // The kernel drops the descriptors for which this process's descriptor table has no room, and
  // reports only that some were dropped.
  const bool dropped = (header.msg_flags & MSG_CTRUNC) != 0;
  if (dropped && !into.descriptors.back()) return ControlRead::NoDescriptors;
  if (!fits || (header.msg_flags & MSG_TRUNC) != 0 ||
      got != static_cast<ssize_t>(sizeof into.message) ||
      into.message.version != ControlMessage::this_version) {
    return ControlRead::Garbage;
  }
  into.message.text.back() = '\0';
  return ControlRead::Message;
}

tl::expected<Peer, std::string> peer_of(int socket) {
  ucred named{};
  socklen_t size = sizeof named;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &named, &size) != 0) {
    return tl::unexpected("the kernel does not report the user of the peer: " + system_text(errno));
  }
  if (named.pid <= 0 || named.uid == nobody || named.uid == static_cast<uid_t>(-1)) {
    return tl::unexpected<std::string>(
        "the peer's user or process is unknown here (another namespace)");
  }
  return Peer{named.uid, named.pid,
              "uid " + std::to_string(named.uid) + ", pid " + std::to_string(named.pid)};
}

tl::expected<Descriptor, std::string> death_of_peer(int socket, std::int32_t pid) {
  int fd = -1;
  socklen_t size = sizeof fd;
  if (::getsockopt(socket, SOL_SOCKET, so_peerpidfd, &fd, &size) == 0) return Descriptor(fd);
  // On older kernels, pidfd_open needs the pid of the peer. If the peer has died, another process
  // may have this pid by now; then only the closed socket shows that the peer has died.
  fd = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  if (fd < 0 && errno == ESRCH) return tl::unexpected<std::string>("the peer's process has ended");
  return Descriptor(fd);
}

bool is_event_fd(int descriptor) {
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  std::array<char, 64> target{};
  const ssize_t length = ::readlink(link.c_str(), target.data(), target.size());
  return length > 0 && std::string_view(target.data(), static_cast<std::size_t>(length)) ==
                           "anon_inode:[eventfd]";
}

}  // namespace gecos::media::shm
