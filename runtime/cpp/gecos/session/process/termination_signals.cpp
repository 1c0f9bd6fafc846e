#include "gecos/session/process/termination_signals.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"

namespace gecos::session {
namespace {

constexpr std::array<int, 2> signals{SIGINT, SIGTERM};

/// `came` and `owner` are the only data that the signal handler uses. They are set before the
/// handler is installed. The object in `came` is never freed.
std::atomic<EventFd*> came{nullptr};
std::atomic<pid_t> owner{0};
static_assert(std::atomic<EventFd*>::is_always_lock_free &&
              std::atomic<pid_t>::is_always_lock_free);

Mutex mutex;
int living GECOS_GUARDED_BY(mutex) = 0;
std::array<struct sigaction, signals.size()> before GECOS_GUARDED_BY(mutex);

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

void TerminationSignals::prepare() {
  const MutexLock lock(mutex);
  if (came == nullptr) came = new EventFd();
}

TerminationSignals::TerminationSignals() {
  prepare();
  const MutexLock lock(mutex);
  if (living++ > 0) return;
  came.load()->drain();
  owner = getpid();
  struct sigaction ours {};
  ours.sa_handler = on_termination;
  ours.sa_flags = SA_RESTART;
  sigfillset(&ours.sa_mask);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    sigaction(signals[i], nullptr, &before[i]);
    if (before[i].sa_handler != SIG_IGN) sigaction(signals[i], &ours, nullptr);
  }
}

TerminationSignals::~TerminationSignals() {
  const MutexLock lock(mutex);
  if (--living > 0) return;
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before[i], nullptr);
}

int TerminationSignals::descriptor() const { return came.load()->descriptor(); }

}  // namespace gecos::session
