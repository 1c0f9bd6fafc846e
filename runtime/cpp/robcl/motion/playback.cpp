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

void Playback::brake(double seconds) {
  // At every speed, the braking limits allow at least the deceleration that the plan's time law has
  // there, because a time law keeps all limits even when it is slowed. Therefore the arm stops at
  // the goal at the latest.
  const double braking = std::min(plan_.braking.near(s_, speed_ * speed_).lower, 0.0);
  const double after = speed_ + braking * seconds;
  if (after <= 0) {
    if (braking < 0) s_ += speed_ * speed_ / (-2 * braking);
    speed_ = 0;
  } else {
    s_ += (speed_ + after) / 2 * seconds;
    speed_ = std::min(after, plan_.law.speed_at(s_));
  }
  s_ = std::min(s_, 1.0);
  standing_ = speed_ <= 0 || s_ >= 1;
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
