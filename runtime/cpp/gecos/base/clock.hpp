// Most functions take the time as a parameter. Code that must read the time uses a Clock, so that
// tests need not sleep.
#pragma once

#include <atomic>
#include <chrono>

namespace gecos {

using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

/// A source of time. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Monotonic time, unrelated to the time of day and to other hosts.
  virtual TimePoint now() const = 0;

  /// Monotonic time that also counts while the machine is suspended (CLOCK_BOOTTIME). Compare it
  /// only with other readings of since_boot().
  virtual TimePoint since_boot() const { return now(); }

  /// True when this clock shows real time, so that other clocks of the system advance with it.
  virtual bool real() const { return false; }

  /// Seconds since 1970 UTC, for stamps that leave the process. An operator may set this clock
  /// back.
  virtual double unix_seconds() const = 0;
};

class SystemClock final : public Clock {
 public:
  TimePoint now() const override;
  TimePoint since_boot() const override;
  bool real() const override { return true; }
  double unix_seconds() const override;
};

/// The time `patience` from now, by the system's clock. Duration::max() gives TimePoint::max():
/// never.
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
  std::atomic<Duration::rep> passed_{0};  // protects no other data
};

}  // namespace gecos
