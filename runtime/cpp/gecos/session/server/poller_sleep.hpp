#pragma once

#include <atomic>

#include "gecos/base/timer_fd.hpp"
#include "gecos/session/process/maintenance.hpp"

namespace gecos::session {

/// Tells the maintenance thread whether the polling thread of a server sleeps. While the polling
/// thread sleeps, the maintenance thread can sleep longer, too.
///
/// When the polling thread has woken, the maintenance thread must check the polling thread within a
/// tick, because a handler may hang on the polling thread. Therefore a polling thread that wakes
/// sets a timer, and the maintenance thread watches the timer. The polling thread sets the timer
/// only if count_on() returned true during the sleep, so a busy server pays only a few atomic
/// operations for each sleep.
class PollerSleep {
 public:
  /// Throws std::system_error when the process cannot open another file descriptor.
  PollerSleep() = default;

  // The polling thread calls these functions before and after it sleeps.
  void begin() { asleep_.store(true); }
  void end() {
    asleep_.store(false);
    woke_.store(true);
    if (counted_on_.exchange(false)) timer_.set(Maintenance::tick);
  }

  // The maintenance thread calls the functions below.

  /// Returns true when the polling thread sleeps and has not woken since the last call of this
  /// function. If so, `descriptor` becomes readable one tick after the polling thread has woken.
  /// Returns false for a polling thread that is woken often, because each timer costs a tick.
  bool count_on() {
    if (woke_.exchange(false)) return false;
    counted_on_.store(true);
    if (asleep_.load()) return true;
    counted_on_.store(false);
    return false;
  }
  int descriptor() const { return timer_.descriptor(); }
  void drain() const { timer_.drain(); }

 private:
  // The polling thread stores to `asleep_` and then reads `counted_on_`; the maintenance thread
  // stores to `counted_on_` and then reads `asleep_`. With the default memory order, at least one
  // of them sees what the other has stored.
  std::atomic<bool> asleep_{false};
  std::atomic<bool> counted_on_{false};
  std::atomic<bool> woke_{false};  // since the last call of count_on()
  TimerFd timer_;
};

}  // namespace gecos::session
