#include "gecos/base/event_fd.hpp"

#include <sys/eventfd.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstdint>

#include "gecos/base/system_error.hpp"

namespace gecos {

EventFd::EventFd() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!fd_) throw_system_error("eventfd", errno);
}

bool EventFd::drain() {
  std::uint64_t count = 0;
  iovec piece{&count, sizeof count};
  // RWF_NOWAIT, because every holder of the descriptor, also an untrusted peer, can clear
  // O_NONBLOCK.
  return ::preadv2(fd_.get(), &piece, 1, -1, RWF_NOWAIT) == static_cast<ssize_t>(sizeof count);
}

void notify_event_fd(int descriptor) {
  const std::uint64_t one = 1;
  // An eventfd whose counter is full is readable already, so a failed write loses no wake-up.
  [[maybe_unused]] const auto ignored = ::write(descriptor, &one, sizeof one);
}

}  // namespace gecos
