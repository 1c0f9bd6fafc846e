#include "gecos/base/timer_fd.hpp"

#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "gecos/base/system_error.hpp"

namespace gecos {

TimerFd::TimerFd() : fd_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
  if (!fd_) throw_system_error("timerfd_create", errno);
}

void TimerFd::set(Duration after) const {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(after);
  itimerspec when{};
  when.it_value.tv_sec = static_cast<time_t>(seconds.count());
  when.it_value.tv_nsec = static_cast<long>((after - seconds).count());
  ::timerfd_settime(fd_.get(), 0, &when, nullptr);
}

void TimerFd::drain() const {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto ignored = ::read(fd_.get(), &count, sizeof count);
}

}  // namespace gecos
