#include "robcl/motion/playback.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {

Playback::Playback(Plan plan) : plan_(std::move(plan)) {}

JointValues Playback::advance(double seconds) {
  if (!standing_ && mode_ != Mode::OnTime) {
    advance_by_pieces(seconds);
  } else if (!standing_) {
    time_ += seconds;
    const TimeLaw::State state = plan_.law.at(time_);
    s_ = state.s;
    speed_ = state.speed;
    standing_ = time_ >= plan_.law.duration();
  }
  return standing_ && s_ >= plan_.path.end() ? plan_.goal() : plan_.path.position(s_);
}

void Playback::set_override(double factor) {
  if (factor == override_) return;
  override_ = factor;
  const bool moves = !standing_ && plan_.law.duration() > 0;
  if (moves && mode_ != Mode::Braking) leave_law(Mode::Scaled);
}

void Playback::stop() {
  if (mode_ != Mode::Braking) leave_law(Mode::Braking);
}

void Playback::rest() {
  if (standing_) return;
  speed_ = 0;
  standing_ = mode_ == Mode::Braking;
  if (!standing_) leave_law(Mode::Scaled);
}

void Playback::leave_law(Mode mode) {
  mode_ = mode;
  piece_.knot = plan_.path.interval_at(s_);
  begin_piece();
}

/// Begins the piece of the path from s_ to the end of the interval.
///
/// The law of the plan, slowed by a constant factor so that it has the present speed here, keeps
/// all limits on the rest of the path (PathBounds). Its d²s/dt² is therefore allowed here, and the
/// arm can always brake so that it stops at the goal at the latest. A path may bend so that an arm
/// which is fast cannot brake yet: then the least allowed d²s/dt² is positive.
///
/// The motion is never faster than the plan: there, the limits may allow nothing.
void Playback::begin_piece() {
  const double step = plan_.path.step(piece_.knot);
  piece_.end = end_of_interval();
  const double way = std::max(piece_.end - s_, 0.0);
  const double part = 1 - std::min(way / step, 1.0);
  const double x = speed_ * speed_;
  const PathBounds::Interval allowed = plan_.braking.over_rest(piece_.knot, part, x);
  const double next = plan_.law.speed(piece_.knot + 1);
  const auto towards = [&](double speed) { return way > 0 ? (speed * speed - x) / (2 * way) : 0; };
  if (mode_ == Mode::Braking || override_ == 0) {
    piece_.acceleration = std::min(allowed.lower, towards(next));
  } else if (next > 0) {
    const double wanted = std::min(allowed.upper, towards(override_ * next));
    piece_.acceleration = std::min(std::max(allowed.lower, wanted), towards(next));
  } else if (x > 0) {
    piece_.acceleration = towards(0);
  } else {  // from rest to the goal: accelerate over the first half of the way
    piece_.end -= way / 2;
    piece_.acceleration = std::min(allowed.upper, plan_.braking.hardest_to_rest(piece_.knot, part));
  }
}

void Playback::advance_by_pieces(double seconds) {
  while (!standing_) {
    const double way = std::max(piece_.end - s_, 0.0), u = piece_.acceleration;
    const double left = speed_ * speed_ + 2 * u * way;  // (ds/dt)² at the end of the piece
    const bool stops = left <= 0;
    const double lasts =
        stops ? (speed_ > 0 ? speed_ / -u : 0) : 2 * way / (speed_ + std::sqrt(left));
    if (seconds < lasts) {
      s_ += seconds * (speed_ + u * seconds / 2);
      speed_ += u * seconds;
      break;
    }
    seconds -= lasts;
    const bool paused = override_ == 0 && mode_ != Mode::Braking;
    if (!stops) {
      s_ = piece_.end;
    } else if (mode_ == Mode::Braking || paused) {
      s_ = std::min(s_ + lasts * speed_ / 2, piece_.end);
    } else {  // the arm stops only at the goal
      s_ = plan_.path.end();
    }
    speed_ = stops ? 0 : std::sqrt(left);
    const bool at_knot = s_ >= end_of_interval();
    if (at_knot) ++piece_.knot;
    const bool at_goal = piece_.knot == plan_.braking.intervals();
    standing_ = at_goal || (stops && !paused);
    if (standing_ || (stops && paused)) break;
    if (mode_ == Mode::Scaled && override_ == 1 && at_knot &&
        speed_ >= plan_.law.speed(piece_.knot) * (1 - 1e-9)) {
      mode_ = Mode::OnTime;
      time_ = plan_.law.time(piece_.knot);
      advance(seconds);
      return;
    }
    begin_piece();
  }
  if (mode_ == Mode::Scaled) {
    time_ = standing_ ? plan_.law.duration() : std::max(time_, plan_.law.time_at(s_));
  }
}

double Playback::fraction() const {
  if (plan_.law.duration() <= 0) return standing_ ? 1 : 0;
  return std::min(1.0, time_ / plan_.law.duration());
}

double Playback::remaining() const {
  if (standing_ || stopping()) return 0;
  const double at_full_speed = std::max(0.0, plan_.law.duration() - time_);
  return override_ > 0 ? at_full_speed / override_ : at_full_speed;
}

}  // namespace robcl::motion
