// Time is passed in. Code that must read it asks a Clock, so that tests need no sleep.
#pragma once

#include <atomic>
#include <chrono>

namespace gecos {

using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// May be asked from every thread.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Never goes back; unrelated to the time of day and to other hosts.
  virtual TimePoint now() const = 0;

  /// Likewise, and goes on while the machine is suspended (CLOCK_BOOTTIME). Only differences to
  /// other readings of it mean something.
  virtual TimePoint since_boot() const { return now(); }

  /// It goes with the time of this world, so that other counters of time tell of it, too.
  virtual bool real() const { return false; }

  /// Seconds since 1970 UTC, for stamps that leave the process. May be set back by an operator.
  virtual double unix_seconds() const = 0;
};

class SystemClock final : public Clock {
 public:
  TimePoint now() const override;
  TimePoint since_boot() const override;
  bool real() const override { return true; }
  double unix_seconds() const override;
};

/// When `patience` from now is over, by the system's clock. Duration::max() is for ever.
TimePoint deadline_after(Duration patience);

/// A clock for tests: it advances only by `advance`. `unix_seconds` advances with it.
class FakeClock final : public Clock {
 public:
  explicit FakeClock(TimePoint start = TimePoint{std::chrono::hours{1}}, double unix_start = 1.7e9);

  TimePoint now() const override;
  double unix_seconds() const override;

  /// @pre `step` is not negative.
  void advance(Duration step);

 private:
  const TimePoint start_;
  const double unix_start_;
  std::atomic<Duration::rep> passed_{0};  // publishes nothing but itself
};

}  // namespace gecos
