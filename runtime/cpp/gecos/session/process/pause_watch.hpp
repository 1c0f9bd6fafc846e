#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "gecos/base/clock.hpp"
#include "gecos/base/moment.hpp"
#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// "stood still for 3.1 s"
std::string stood_still_for(Duration pause);

/// Detects that this process was suspended: SIGSTOP, a suspended machine, a core that was taken
/// away.
///
/// At each tick the maintenance thread sets when the next one is due. A tick that is late by more
/// than `longest_gap`, or would be if it came now, means a pause. After a pause no call may start
/// until maintenance has judged the pause: packets in the rings are as old as the pause, and peers
/// that died meanwhile are not known yet. Times are of CLOCK_BOOTTIME.
class PauseWatch {
 public:
  static constexpr Duration longest_gap = std::chrono::milliseconds(500);

  /// Called by maintenance at each tick. Returns the length of the pause that ends here, if there
  /// was one; then no call starts until judged().
  std::optional<Duration> tick(TimePoint now) {
    const TimePoint due = due_.load(std::memory_order_relaxed);
    if (due == TimePoint::max() || now - due <= longest_gap) {
      due_.store(now, std::memory_order_relaxed);  // a pause may fall into the work of this tick
      return std::nullopt;
    }
    judging_.store(true, std::memory_order_relaxed);
    return now - due;
  }
  /// Called by maintenance after it has applied the pause to all sessions and commands.
  void judged(TimePoint next_due) {
    {
      const MutexLock lock(mutex_);
      due_.store(next_due, std::memory_order_release);
      judging_.store(false, std::memory_order_release);
    }
    judged_.notify_all();
  }
  /// Called by the maintenance thread before it sleeps until `next`. TimePoint::max(): until it is
  /// woken. Returns false when there was a pause since its tick; the next tick is then due now.
  [[nodiscard]] bool due(TimePoint next, TimePoint now) {
    if (suspected(now)) return false;
    due_.store(next, std::memory_order_relaxed);
    return true;
  }

  /// For any thread before it starts a handler: whether a pause has ended and is not judged yet.
  bool suspected(TimePoint now) const {
    const TimePoint due = due_.load(std::memory_order_relaxed);
    return judging_.load(std::memory_order_acquire) ||
           (due != TimePoint::max() && now - due > longest_gap);
  }
  /// The last check of a thread that checks often, if it found no pause.
  struct Checked {
    Moment moment;
    TimePoint at{};  ///< at most a tick of the kernel ago
  };
  /// As above, but does not read the clock at every call.
  bool suspected(const Clock& clock, Checked& checked, Moment now = Moment::now()) const {
    if (judging_.load(std::memory_order_acquire)) return true;
    if (now == checked.moment) return false;
    checked.at = clock.since_boot();
    const bool suspicious = suspected(checked.at);
    checked.moment = suspicious || !clock.real() ? Moment{} : now;
    return suspicious;
  }
  /// Waits until the pause is judged. Must not be called on the maintenance thread.
  void await_judgement(const Clock& clock) {
    if (!suspected(clock.since_boot())) return;
    MutexLock lock(mutex_);
    // A tick that is late, but not late enough for a pause, sends no notification.
    while (suspected(clock.since_boot())) judged_.wait_for(lock, longest_gap / 50);
  }

 private:
  std::atomic<TimePoint> due_{TimePoint::max()};  // publishes nothing but itself
  std::atomic<bool> judging_{false};  // clearing it publishes the work of the maintenance thread
  Mutex mutex_;
  ConditionVariable judged_;
};

}  // namespace gecos::session
