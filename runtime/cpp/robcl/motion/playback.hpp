// The execution of a plan, one control cycle after the other.
#pragma once

#include "robcl/motion/plan.hpp"

namespace robcl::motion {

/// Computes the set points of the joints for each control cycle of a plan. Never allocates memory,
/// locks or logs.
class Playback {
 public:
  explicit Playback(Plan plan);

  /// Advances the time by `seconds` and returns the set points of the joints.
  JointValues advance(double seconds);

  /// Makes the following calls of `advance` decelerate on the path, as hard as the arm's limits
  /// allow, until the arm stands somewhere on the path.
  void stop();

  bool standing() const { return standing_; }
  bool stopping() const { return stopping_; }
  /// Returns the fraction of the plan's duration that has passed, from 0 to 1. It does not rise
  /// after `stop`.
  double fraction() const;
  /// Returns the remaining time to the goal in s; 0 after `stop` and at the goal.
  double remaining() const;
  const Plan& plan() const { return plan_; }

 private:
  void brake(double seconds);
  void enter_interval();

  Plan plan_;
  double time_ = 0;  // s since the start; does not rise while stopping
  double s_ = 0;
  double speed_ = 0;      // ds/dt
  std::size_t knot_ = 0;  // while stopping: the start of the interval in which s_ lies
  double braking_ = 0;    // while stopping: d²s/dt² in this interval
  bool stopping_ = false;
  bool standing_ = false;
};

}  // namespace robcl::motion
