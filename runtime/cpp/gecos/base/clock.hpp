// Most functions of this project take the time as a parameter. Code that must read the time uses a
// Clock, so that tests can replace the clock and need not sleep.
#pragma once

#include <atomic>
#include <chrono>

namespace gecos {

using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// One moment by two clocks.
struct TimeByBoth {
  Duration unix_time{};
  TimePoint since_boot{};
};

/// A source of time. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Returns monotonic time, which is unrelated to the time of day and to the clocks of other
  /// hosts.
  virtual TimePoint now() const = 0;

  /// Returns monotonic time that also advances while the machine is suspended (CLOCK_BOOTTIME).
  /// Compare the returned time only with other results of since_boot().
  virtual TimePoint since_boot() const { return now(); }

  /// Returns true when this clock shows real time, so that other clocks of the system advance
  /// together with this clock.
  virtual bool real() const { return false; }

  /// Returns the time since 1970 UTC, for time stamps that leave the process. An operator may set
  /// this clock back.
  virtual Duration unix_time() const = 0;

  /// Returns `unix_time()` and `since_boot()` of the same moment.
  virtual TimeByBoth by_both() const { return {unix_time(), since_boot()}; }
};

class SystemClock final : public Clock {
 public:
  TimePoint now() const override;
  TimePoint since_boot() const override;
  bool real() const override { return true; }
  Duration unix_time() const override;
  /// Reads CLOCK_BOOTTIME, and the wall clock only at the first call on this thread and after the
  /// wall clock was set. Both times belong to one moment within 10 µs, unless the thread is
  /// interrupted at each of three tries.
  TimeByBoth by_both() const override;
};

/// Returns the time that is `patience` from now by the system's clock. For Duration::max(), returns
/// TimePoint::max(), a deadline that never comes.
TimePoint deadline_after(Duration patience);

/// A clock for tests. Both its monotonic time and its `unix_time` advance only when `advance` is
/// called.
class FakeClock final : public Clock {
 public:
  explicit FakeClock(TimePoint start = TimePoint{std::chrono::hours{1}},
                     Duration unix_start = std::chrono::seconds{1'700'000'000});

  TimePoint now() const override;
  Duration unix_time() const override;

  /// @pre `step` is not negative.
  void advance(Duration step);

 private:
  const TimePoint start_;
  const Duration unix_start_;
  std::atomic<Duration::rep> passed_{0};  // protects no other data
};

}  // namespace gecos
