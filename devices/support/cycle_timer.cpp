#include "devices/support/cycle_timer.hpp"

#include <algorithm>
#include <chrono>

namespace devices {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

CycleTimer::CycleTimer(gecos::Duration period, double speed, gecos::TimePoint start)
    : period_(period), speed_(speed), last_(start), measured_since_(start), reached_(speed) {}

CycleTimer::Cycle CycleTimer::next(gecos::TimePoint now) {
  measure(now);
  Cycle cycle{last_ + period_, Seconds(period_).count()};
  if (speed_ != 1) {
    const auto step = std::chrono::round<gecos::Duration>(Seconds(period_) / speed_);
    cycle.begins = std::max(last_ + step, now - most_behind);
  } else if (now > cycle.begins + period_) {
    cycle.begins += (now - cycle.begins) / period_ * period_;
    cycle.seconds = Seconds(cycle.begins - last_).count();
  }
  last_ = cycle.begins;
  simulated_ += cycle.seconds;
  return cycle;
}

/// During the first window, the mean over the time so far is reported, because the requested speed
/// may be far from the real one.
void CycleTimer::measure(gecos::TimePoint now) {
  const gecos::Duration passed = now - measured_since_;
  const bool full = passed >= window;
  if (passed > gecos::Duration::zero() && (full || first_window_)) {
    reached_ = simulated_ / Seconds(passed).count();
  }
  if (!full) return;
  first_window_ = false;
  measured_since_ = now;
  simulated_ = 0;
}

}  // namespace devices
