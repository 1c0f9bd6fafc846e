#include "robcl/motion/playback.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {

Playback::Playback(Plan plan) : entered_(nullptr), start_(plan.start()) {
  stages_.push_back(std::make_unique<Stage>(std::move(plan), 0, 0));
  stage_ = stages_.front().get();
  entered_.store(stage_);
}

void Playback::append(Plan plan, double begins) {
  const Stage* const entered = entered_.load();
  while (stages_.front().get() != entered) stages_.pop_front();
  auto next = std::make_unique<Stage>(std::move(plan), begins, stages_.back()->number + 1);
  stages_.back()->next.store(next.get());
  stages_.push_back(std::move(next));
}

JointValues Playback::advance(double seconds) {
  if (!standing_ && mode_ != Mode::OnTime) {
    advance_by_pieces(seconds);
  } else if (!standing_) {
    advance_by_law(seconds);
  }
  elapsed_.store(stage_->begins + time_);
  return standing_ && s_ >= plan().path.end() ? plan().goal() : plan().path.position(s_);
}

void Playback::advance_by_law(double seconds) {
  const double before = time_;
  time_ += seconds;
  const Stage* const next = stage_->next.load();
  if (next != nullptr) {
    const double switches = next->begins - stage_->begins;
    if (before <= switches && switches <= time_) {
      enter(*next);
      return advance_by_law(before + seconds - switches);
    }
  }
  const TimeLaw::State state = plan().law.at(time_);
  s_ = state.s;
  speed_ = state.speed;
  standing_ = time_ >= plan().law.duration();
}

/// Enters the stages that take over at the place where the motion is; several may do so at the same
/// knot. Returns whether there was one.
bool Playback::enter_stages_here() {
  bool entered = false;
  for (const Stage* next = stage_->next.load(); next != nullptr && next->plan.path.begin() == s_;
       next = stage_->next.load()) {
    enter(*next);
    piece_ = {};
    entered = true;
  }
  return entered;
}

void Playback::enter(const Stage& next) {
  stage_ = &next;
  entered_.store(&next);
  time_ = 0;
}

void Playback::set_override(double factor) {
  if (factor == override_) return;
  override_ = factor;
  const bool moves = !standing_ && plan().law.duration() > 0;
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
  piece_ = {};
  piece_.knot = plan().path.interval_at(s_);
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
  const double step = plan().path.step(piece_.knot);
  piece_.end = end_of_interval();
  const double way = std::max(piece_.end - s_, 0.0);
  const double part = 1 - std::min(way / step, 1.0);
  const double x = speed_ * speed_;
  const PathBounds::Interval allowed = plan().braking.over_rest(piece_.knot, part, x);
  const double next = plan().law.speed(piece_.knot + 1);
  const auto towards = [&](double speed) { return way > 0 ? (speed * speed - x) / (2 * way) : 0; };
  if (mode_ == Mode::Braking || override_ == 0) {
    piece_.acceleration = std::min(allowed.lower, towards(next));
  } else if (next > 0) {
    const double wanted = std::min(allowed.upper, towards(override_ * next));
    piece_.acceleration = std::min(std::max(allowed.lower, wanted), towards(next));
  } else {
    begin_last_piece(way, part, x, allowed.upper);
  }
}

/// Begins a piece of the last interval, `way` before the goal and at the fraction `part` of the
/// interval: the motion accelerates by at most `most`, as long as it can then brake to rest at the
/// goal. `x` is (ds/dt)².
void Playback::begin_last_piece(double way, double part, double x, double most) {
  const double law_speed = override_ * plan().law.speed(piece_.knot);
  const double braking = std::min(plan().braking.hardest_to_rest(piece_.knot, part),
                                  law_speed * law_speed / (2 * plan().path.step(piece_.knot)));
  const double acceleration = std::min(most, braking);
  const double before = (2 * braking * way - x) / (2 * (acceleration + braking));
  constexpr double too_short = 0.01;
  if (!piece_.brakes_after && acceleration > 0 && before > too_short * way) {
    piece_.brakes_after = true;
    piece_.end = s_ + before;
    piece_.acceleration = acceleration;
  } else {
    piece_.acceleration = way > 0 ? -x / (2 * way) : 0;
  }
}

void Playback::advance_by_pieces(double seconds) {
  if (mode_ == Mode::Scaled && enter_stages_here()) begin_piece();
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
      s_ = plan().path.end();
    }
    speed_ = stops ? 0 : std::sqrt(left);
    const bool at_knot = s_ >= end_of_interval();
    if (at_knot) ++piece_.knot;
    if (at_knot && mode_ == Mode::Scaled) enter_stages_here();
    const bool at_goal = piece_.knot == plan().braking.intervals();
    standing_ = at_goal || (stops && !paused);
    if (standing_ || (stops && paused)) break;
    if (mode_ == Mode::Scaled && override_ == 1 && at_knot &&
        speed_ >= plan().law.speed(piece_.knot) * (1 - 1e-9)) {
      mode_ = Mode::OnTime;
      time_ = plan().law.time(piece_.knot);
      return advance_by_law(seconds);
    }
    begin_piece();
  }
  if (mode_ == Mode::Scaled) {
    time_ = standing_ ? plan().law.duration() : std::max(time_, plan().law.time_at(s_));
  }
}

double Playback::fraction() const {
  if (plan().law.duration() <= 0) return standing_ ? 1 : 0;
  return std::min(1.0, time_ / plan().law.duration());
}

double Playback::remaining() const {
  if (standing_ || stopping()) return 0;
  const double at_full_speed = std::max(0.0, plan().law.duration() - time_);
  return override_ > 0 ? at_full_speed / override_ : at_full_speed;
}

}  // namespace robcl::motion
