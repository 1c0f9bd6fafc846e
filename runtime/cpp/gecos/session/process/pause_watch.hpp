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

/// Notices that this process stood still: SIGSTOP, a suspended machine, a core that was taken away.
///
/// The maintenance thread says at each tick by when the next one is due. A tick that is late by
/// more than `longest_gap`, or would be if it came now, is a pause. Between the end of a pause and
/// the moment at which maintenance has judged it nothing may start: what lies in the rings is as
/// old as the pause, and nobody knows yet who died meanwhile. Times are of CLOCK_BOOTTIME.
class PauseWatch {
 public:
  static constexpr Duration longest_gap = std::chrono::milliseconds(500);

  /// Maintenance, at each tick. The length of the pause that ends here, if there was one; then
  /// nothing starts until judged().
  std::optional<Duration> tick(TimePoint now) {
    const TimePoint due = due_.load(std::memory_order_relaxed);
    if (due == TimePoint::max() || now - due <= longest_gap) {
      due_.store(now, std::memory_order_relaxed);  // its work may be where a pause falls
      return std::nullopt;
    }
    judging_.store(true, std::memory_order_relaxed);
    return now - due;
  }
  /// Maintenance: sessions and commands are as the pause left them to be.
  void judged(TimePoint next_due) {
    {
      const MutexLock lock(mutex_);
      due_.store(next_due, std::memory_order_release);
      judging_.store(false, std::memory_order_release);
    }
    judged_.notify_all();
  }
  /// For the maintenance thread before it sleeps. TimePoint::max(): until it is woken. False: there
  /// was a pause since its tick, and the next tick is due now.
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
  /// When a thread that asks often found no pause.
  struct Checked {
    Moment moment;
    TimePoint at{};  ///< at most a tick of the kernel ago
  };
  /// Likewise, and reads the clock only now and then.
  bool suspected(const Clock& clock, Checked& checked, Moment now = Moment::now()) const {
    if (judging_.load(std::memory_order_acquire)) return true;
    if (now == checked.moment) return false;
    checked.at = clock.since_boot();
    const bool suspicious = suspected(checked.at);
    checked.moment = suspicious || !clock.real() ? Moment{} : now;
    return suspicious;
  }
  /// Waits until it is judged. Never on the maintenance thread.
  void await_judgement(const Clock& clock) {
    if (!suspected(clock.since_boot())) return;
    MutexLock lock(mutex_);
    // A tick that came as late as is just no pause tells nobody.
    while (suspected(clock.since_boot())) judged_.wait_for(lock, longest_gap / 50);
  }

 private:
  std::atomic<TimePoint> due_{TimePoint::max()};  // publishes nothing but itself
  std::atomic<bool> judging_{false};              // cleared: publishes what the judge did
  Mutex mutex_;
  ConditionVariable judged_;
};

}  // namespace gecos::session
