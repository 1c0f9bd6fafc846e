#include "gecos/session/process/wakeup.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "gecos/base/system_error.hpp"

namespace gecos::session {

Wakeup::Wakeup() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (descriptor_ < 0) throw_system_error("eventfd", errno);
}

Wakeup::~Wakeup() { close(descriptor_); }

void Wakeup::ring() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);  // full means rung
}

void Wakeup::quiet() {
  std::uint64_t rung = 0;
  [[maybe_unused]] const auto got = read(descriptor_, &rung, sizeof rung);  // empty means quiet
}

}  // namespace gecos::session
