#include "gecos/session/server/epoll.hpp"

#include <cerrno>

#include "gecos/base/system_error.hpp"

namespace gecos::session {

Epoll::Epoll() : descriptor_(epoll_create1(EPOLL_CLOEXEC)) {
  if (!descriptor_) throw_system_error("epoll_create1", errno);
}

void Epoll::add(int descriptor, std::uint64_t key) {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLET;
  event.data.u64 = key;
  if (epoll_ctl(descriptor_.get(), EPOLL_CTL_ADD, descriptor, &event) != 0 && errno != EEXIST) {
    throw_system_error("epoll_ctl", errno);
  }
}

std::span<const epoll_event> Epoll::wait(std::span<epoll_event> room, int milliseconds) {
  const int count =
      epoll_wait(descriptor_.get(), room.data(), static_cast<int>(room.size()), milliseconds);
  return room.first(count > 0 ? static_cast<std::size_t>(count) : 0);
}

}  // namespace gecos::session
