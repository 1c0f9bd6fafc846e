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
  // RWF_NOWAIT is needed, because every process that holds the descriptor, even an untrusted peer,
  // can clear O_NONBLOCK.
  return ::preadv2(fd_.get(), &piece, 1, -1, RWF_NOWAIT) == static_cast<ssize_t>(sizeof count);
}

void notify_event_fd(int descriptor) {
  const std::uint64_t one = 1;
  // The write fails only when the counter of the eventfd is full. The eventfd is then readable
  // already, so that no wake-up is lost.
  [[maybe_unused]] const auto ignored = ::write(descriptor, &one, sizeof one);
}

}  // namespace gecos
