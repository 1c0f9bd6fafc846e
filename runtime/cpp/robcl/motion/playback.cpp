#include "robcl/motion/playback.hpp"

#include <algorithm>

namespace robcl::motion {

Playback::Playback(Plan plan)
    : entered_(nullptr),
      start_(plan.start()),
      lag_(plan.smoothing.window),
      traversal_(*stages_.emplace_back(std::make_unique<Stage>(std::move(plan), 0, 0))),
      shown_(stages_.front().get()),
      places_(shown_->plan.smoothing.cycles, traversal_.s()) {
  entered_.store(shown_);
}

void Playback::append(Plan plan, double begins) {
  const Stage* const entered = entered_.load();
  while (stages_.front().get() != entered) stages_.pop_front();
  auto next = std::make_unique<Stage>(std::move(plan), begins, stages_.back()->number + 1);
  stages_.back()->next.store(next.get());
  stages_.push_back(std::move(next));
}

JointValues Playback::advance(double seconds) {
  if (traversal_.standing()) tail_ = std::min(tail_ + seconds, lag_);
  traversal_.advance(seconds);
  if (seconds > 0) places_.add(traversal_.s());
  elapsed_.store(traversal_.stage().begins + traversal_.time());
  standing_ = traversal_.standing() && places_.constant();
  const double s = places_.mean();
  while (shown_ != &traversal_.stage() && s >= shown_->next.load()->place_of_entry()) {
    shown_ = shown_->next.load();
    entered_.store(shown_);
  }
  const Plan& plan = shown_->plan;
  return standing_ && s >= plan.path.end() ? plan.goal() : plan.path.position(s);
}

void Playback::rest() {
  if (standing_) return;
  const double s = places_.mean();
  places_.fill(s);
  traversal_.rest(*shown_, s);
  standing_ = traversal_.standing();
}

double Playback::fraction() const {
  const Plan& plan = traversal_.stage().plan;
  if (standing_ && !stopping()) return 1;  // a little before the end, all places may be equal
  if (plan.duration() <= 0) return 0;
  return std::min(1.0, (traversal_.time() + tail_) / plan.duration());
}

double Playback::remaining() const {
  if (standing_ || stopping()) return 0;
  const Plan& plan = traversal_.stage().plan;
  const double at_full_speed = std::max(0.0, plan.law.duration() - traversal_.time());
  const double factor = traversal_.speed_override();
  return (factor > 0 ? at_full_speed / factor : at_full_speed) + lag_ - tail_;
}

}  // namespace robcl::motion
