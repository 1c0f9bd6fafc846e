#include "gecos/session/signal_descriptor.hpp"

#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace gecos::session {

SignalDescriptor::SignalDescriptor(const sigset_t& signals)
    : descriptor_(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "signalfd");
}

SignalDescriptor::~SignalDescriptor() { close(descriptor_); }

void SignalDescriptor::take() const {
  signalfd_siginfo came{};
  [[maybe_unused]] const auto got = read(descriptor_, &came, sizeof came);
}

}  // namespace gecos::session
