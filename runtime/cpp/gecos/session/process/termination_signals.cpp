#include "gecos/session/process/termination_signals.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/per_process.hpp"

namespace gecos::session {
namespace {

constexpr std::array<int, 2> signals{SIGINT, SIGTERM};

struct Handling {
  EventFd came;
  Mutex mutex;
  int living GECOS_GUARDED_BY(mutex) = 0;
  std::array<struct sigaction, signals.size()> before GECOS_GUARDED_BY(mutex) = {};
};

constinit PerProcess<Handling> handling;

/// `came` and `owner` are the only data that the signal handler uses. They are set before the
/// handler is installed. The object in `came` is never freed.
std::atomic<const EventFd*> came{nullptr};
std::atomic<pid_t> owner{0};
static_assert(std::atomic<const EventFd*>::is_always_lock_free &&
              std::atomic<pid_t>::is_always_lock_free);

extern "C" void on_termination(int signal) {
  const int kept = errno;
  if (getpid() == owner) {
    came.load()->notify();
  } else {  // a forked child must not notify: the parent shares the descriptor
    ::signal(signal, SIG_DFL);
    raise(signal);
  }
  errno = kept;
}

}  // namespace

void TerminationSignals::prepare() { handling.get(); }

TerminationSignals::TerminationSignals() : made_by_(getpid()) {
  Handling& state = handling.get();
  const MutexLock lock(state.mutex);
  if (state.living++ > 0) return;
  state.came.drain();
  came = &state.came;
  owner = made_by_;
  struct sigaction ours {};
  ours.sa_handler = on_termination;
  ours.sa_flags = SA_RESTART;
  sigfillset(&ours.sa_mask);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    struct sigaction& before = state.before[i];
    sigaction(signals[i], nullptr, &before);
    if (before.sa_handler == on_termination) before.sa_handler = SIG_DFL;  // of the parent
    if (before.sa_handler != SIG_IGN) sigaction(signals[i], &ours, nullptr);
  }
}

TerminationSignals::~TerminationSignals() {
  if (made_by_ != getpid()) return;  // a forked child has not installed these handlers
  Handling& state = handling.get();
  const MutexLock lock(state.mutex);
  if (--state.living > 0) return;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    sigaction(signals[i], &state.before[i], nullptr);
  }
}

int TerminationSignals::descriptor() const { return handling.get().came.descriptor(); }

}  // namespace gecos::session
