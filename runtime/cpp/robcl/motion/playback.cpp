#include "robcl/motion/playback.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {

Playback::Playback(Plan plan) : plan_(std::move(plan)) {}

JointValues Playback::advance(double seconds) {
  if (standing_) return plan_.path.position(s_);
  if (stopping_) {
    brake(seconds);
    return plan_.path.position(s_);
  }
  time_ += seconds;
  const TimeLaw::State state = plan_.law.at(time_);
  s_ = state.s;
  speed_ = state.speed;
  standing_ = time_ >= plan_.law.duration();
  return standing_ ? plan_.goal() : plan_.path.position(s_);
}

void Playback::stop() {
  if (stopping_) return;
  stopping_ = true;
  const std::size_t intervals = plan_.braking.intervals();
  knot_ = std::min(static_cast<std::size_t>(s_ * static_cast<double>(intervals)), intervals - 1);
  enter_interval();
}

/// Chooses the hardest braking that the limits allow up to the end of the interval.
///
/// A path may bend so that an arm which is fast cannot brake yet, and must even accelerate: then
/// the least allowed d²s/dt² is positive. The law of the plan, slowed so that it has the present
/// speed here, keeps all limits on the rest of the path (PathBounds). Therefore the least allowed
/// d²s/dt² is never greater than that of the slowed law, and the arm stops at the goal at the
/// latest.
void Playback::enter_interval() {
  const double step = plan_.braking.step();
  const double start = static_cast<double>(knot_) * step;
  const double part = std::clamp((s_ - start) / step, 0.0, 1.0);
  const double x = speed_ * speed_, way = (1 - part) * step;
  braking_ = plan_.braking.over_interval(knot_, x, part).lower;
  const double next = plan_.law.speed(knot_ + 1);
  if (way > 0) braking_ = std::min(braking_, (next * next - x) / (2 * way));
}

void Playback::brake(double seconds) {
  while (!standing_) {
    const double end = static_cast<double>(knot_ + 1) * plan_.braking.step();
    const double way = std::max(end - s_, 0.0);
    const double left = speed_ * speed_ + 2 * braking_ * way;  // (ds/dt)² at the end
    const bool stops = speed_ <= 0 || left <= 0;
    const double lasts =
        stops ? (speed_ <= 0 ? 0 : speed_ / -braking_) : 2 * way / (speed_ + std::sqrt(left));
    if (seconds < lasts) {
      s_ += seconds * (speed_ + braking_ * seconds / 2);
      speed_ += braking_ * seconds;
      return;
    }
    seconds -= lasts;
    s_ = stops ? std::min(s_ + lasts * speed_ / 2, end) : end;
    speed_ = stops ? 0 : std::sqrt(left);
    standing_ = stops || ++knot_ == plan_.braking.intervals();
    if (!standing_) enter_interval();
  }
}

double Playback::fraction() const {
  if (plan_.law.duration() <= 0) return standing_ ? 1 : 0;
  return std::min(1.0, time_ / plan_.law.duration());
}

double Playback::remaining() const {
  if (standing_ || stopping_) return 0;
  return std::max(0.0, plan_.law.duration() - time_);
}

}  // namespace robcl::motion
