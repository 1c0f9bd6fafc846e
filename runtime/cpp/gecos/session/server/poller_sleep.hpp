#pragma once

#include <atomic>

#include "gecos/base/timer_fd.hpp"
#include "gecos/session/process/maintenance.hpp"

namespace gecos::session {

/// Tells the maintenance thread whether the polling thread of a server sleeps, so that it can rest
/// longer while nothing happens.
///
/// The maintenance thread must look within a tick at what a polling thread does that has woken: a
/// handler may hang. So a polling thread that wakes sets a timer, which the maintenance thread
/// watches. It does so only if the maintenance thread has counted on its sleep, so a busy server
/// pays only a few atomic operations for each sleep.
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
  /// Returns whether the polling thread sleeps and has slept since the last call of this function.
  /// If so, `descriptor` becomes readable one tick after it has woken. A thread that is woken often
  /// is not counted on, because each timer costs a tick.
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
  // Each thread stores to its own flag and then reads that of the other, so at least one of them
  // sees what the other has stored. That needs the default memory order.
  std::atomic<bool> asleep_{false};
  std::atomic<bool> counted_on_{false};
  std::atomic<bool> woke_{false};  // since the last call of count_on()
  TimerFd timer_;
};

}  // namespace gecos::session
