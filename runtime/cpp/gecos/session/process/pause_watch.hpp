#pragma once

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>

#include "gecos/base/clock.hpp"
#include "gecos/base/moment.hpp"
#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// Returns a text such as "stood still for 3.1 s".
std::string stood_still_for(Duration pause);

/// Detects a pause: a time in which this process did not run, because of SIGSTOP, because the
/// machine was suspended, or because the process got no core.
///
/// Before each sleep the maintenance thread records the time at which its next tick is due. A sleep
/// must not hide a pause, so for a sleep of 25 to 125 ms the recorded time is 25 ms from now. If
/// the next tick comes more than `longest_gap` (500 ms) after the recorded time, or has not come by
/// then, there was a pause. So a pause that begins with the sleep is noticed if it takes more than
/// 525 ms, and one that begins at the end of a sleep of 125 ms if it takes more than 400 ms.
/// After a pause no call may start until the maintenance thread has judged the pause: packets that
/// wait to be read may be as old as the pause, and peers may have died during the pause. All times
/// are times of CLOCK_BOOTTIME.
class PauseWatch {
 public:
  static constexpr Duration longest_gap = std::chrono::milliseconds(500);

  /// Called by the maintenance thread at each tick. If a pause ends with this tick, returns the
  /// length of the pause; then no call starts before judged() is called.
  std::optional<Duration> tick(TimePoint now) {
    const TimePoint due = due_.load(std::memory_order_relaxed);
    if (due == TimePoint::max() || now - due <= longest_gap) {
      // The time of this tick is stored, so that a pause during this tick is detected, too.
      due_.store(now, std::memory_order_relaxed);
      next_ = now;
      return std::nullopt;
    }
    judging_.store(true, std::memory_order_relaxed);
    ended_.store(now, std::memory_order_relaxed);
    return now - std::min(next_, now);
  }
  /// Called by the maintenance thread after it has told all sessions and commands of the pause.
  void judged(TimePoint next_due) {
    {
      const MutexLock lock(mutex_);
      due_.store(next_due, std::memory_order_release);
      next_ = next_due;
      judging_.store(false, std::memory_order_release);
    }
    judged_.notify_all();
  }
  /// Called by the maintenance thread before it sleeps until `next` (TimePoint::max(): until it is
  /// woken). Returns false when there was a pause since the last tick; the thread must then tick at
  /// once.
  [[nodiscard]] bool due(TimePoint next, TimePoint now) {
    if (suspected(now)) return false;
    due_.store(counted(next, now), std::memory_order_relaxed);
    next_ = next;
    return true;
  }

  /// Returns true when a pause has ended and is not judged yet. Every thread must call this
  /// function before it starts a handler.
  bool suspected(TimePoint now) const {
    const TimePoint due = due_.load(std::memory_order_relaxed);
    return judging_.load(std::memory_order_acquire) ||
           (due != TimePoint::max() && now - due > longest_gap);
  }
  /// The last check by which a thread found no pause. A thread that checks often keeps this object
  /// and passes it to suspected().
  struct Checked {
    Moment moment;
    TimePoint at{};  ///< time of the check, at most one kernel tick ago
  };
  /// Like suspected(now), but reads the precise clock at most once per kernel tick. `checked`: the
  /// last check of the calling thread.
  bool suspected(const Clock& clock, Checked& checked, Moment now = Moment::now()) const {
    if (judging_.load(std::memory_order_acquire)) return true;
    if (now == checked.moment) return false;
    checked.at = clock.since_boot();
    const bool suspicious = suspected(checked.at);
    checked.moment = suspicious || !clock.real() ? Moment{} : now;
    return suspicious;
  }
  /// Returns when the last pause ended that a tick has found; TimePoint::min() if there was none.
  TimePoint ended() const { return ended_.load(std::memory_order_relaxed); }
  /// Waits until the pause is judged. Must not be called on the maintenance thread.
  void await_judgement(const Clock& clock) {
    if (!suspected(clock.since_boot())) return;
    MutexLock lock(mutex_);
    // A late tick that does not count as a pause sends no notification, so the loop checks at
    // intervals.
    while (suspected(clock.since_boot())) judged_.wait_for(lock, longest_gap / 50);
  }

 private:
  static TimePoint counted(TimePoint next, TimePoint now) {
    constexpr Duration calm = std::chrono::milliseconds(25);
    constexpr Duration most_hidden = std::chrono::milliseconds(100);
    if (next == TimePoint::max()) return next;
    return next - std::clamp(next - now - calm, Duration::zero(), most_hidden);
  }

  TimePoint next_{};  ///< when the next tick is due; used by the maintenance thread only
  std::atomic<TimePoint> due_{TimePoint::max()};    // orders no other memory
  std::atomic<TimePoint> ended_{TimePoint::min()};  // `judging_` publishes it to all who may start
  std::atomic<bool> judging_{false};  // storing false publishes the work of the maintenance thread
  Mutex mutex_;
  ConditionVariable judged_;
};

}  // namespace gecos::session
