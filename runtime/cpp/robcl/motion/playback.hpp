// The execution of a plan, one control cycle after the other.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>

#include "robcl/motion/moving_window.hpp"
#include "robcl/motion/plan.hpp"
#include "robcl/motion/trajectory_generator.hpp"
#include "robcl/motion/traversal.hpp"

namespace robcl::motion {

/// Computes the set points of the joints for each control cycle of a plan. Only the control loop
/// calls the functions other than `append`, `elapsed`, `entered` and `lag`. The functions that the
/// control loop calls never allocate memory, lock or log.
class Playback final : public TrajectoryGenerator {
 public:
  /// @pre `plan` begins at rest.
  explicit Playback(Plan plan);

  /// Makes the motion go over into `plan` at the knot `plan.entry`. Up to this knot, `plan` is a
  /// part of the last plan. `begins` is the time in s at which the time law of `plan` begins, by
  /// the time laws of all plans so far. If the motion brakes or has already passed the knot, the
  /// motion ends as if `append` had not been called. Only one thread may call this function. This
  /// thread need not be the thread of the control loop.
  void append(Plan plan, double begins);
  /// Returns the number of the plan on whose path the set points are: 0 for the first one, 1 for
  /// the first one that was appended. Only the thread that appends may call this function.
  std::size_t entered() const { return entered_.load()->number; }
  /// Returns the time in s since the start, by the time laws of the plans. While an override slows
  /// the motion, this time rises more slowly than real time. After `stop` it does not rise. With a
  /// limit of jerk, the set points lag behind this time by lag(). Any thread may call this
  /// function.
  double elapsed() const { return elapsed_.load(); }
  /// Returns the greatest time in s by which the set points lag behind the time laws. Any thread
  /// may call this function.
  double lag() const { return lag_; }

  const JointValues& start() const override { return start_; }
  JointValues advance(double seconds) override;
  void set_override(double factor) override { traversal_.set_override(factor); }

  /// Makes the following calls of `advance` decelerate on the path, as hard as the arm's limits
  /// allow, until the arm stands somewhere on the path.
  void stop() override { traversal_.stop(); }
  /// Must be called when the joints have stopped on the path because no set points were sent to
  /// them for some cycles. The motion then starts again from rest: the following calls of `advance`
  /// accelerate until the motion follows its plan again. If `stop` was called before, the motion
  /// ends instead.
  void rest() override;

  bool standing() const override { return standing_; }
  bool stopping() const override { return traversal_.stopping(); }
  /// Returns the fraction of the plan's duration that has passed, from 0 to 1. The fraction does
  /// not rise after `stop`. The plan is the one that the motion follows now, including the part
  /// before `Plan::entry`.
  double fraction() const override;
  /// Returns the remaining time to the goal in s; 0 after `stop` and at the goal. While the arm
  /// accelerates after `rest`, the returned time is too short. While the motion is paused, the time
  /// assumes that the motion continues at full speed.
  double remaining() const override;

 private:
  std::deque<std::unique_ptr<Stage>> stages_;  // used by the thread that appends
  std::atomic<const Stage*> entered_;          // the stages before it are not used any more
  std::atomic<double> elapsed_{0};             // orders no other memory

  const JointValues start_;
  const double lag_;
  Traversal traversal_;
  const Stage* shown_;   // its path has the set points
  MovingWindow places_;  // s in the last cycles
  double tail_ = 0;      // time in s since the time law ended, up to lag_
  bool standing_ = false;
};

}  // namespace robcl::motion
