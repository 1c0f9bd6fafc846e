// A plan while it runs.
#pragma once

#include "robcl/motion/plan.hpp"

namespace robcl::motion {

/// Gives the joints' command once a clock. Allocates, locks and logs nothing.
class Playback {
 public:
  explicit Playback(Plan plan);

  /// Goes on by `seconds` and says where the joints shall be then.
  JointValues advance(double seconds);

  /// Decelerates on the path, as hard as the arm's own limits allow. It then stands somewhere on
  /// it.
  void stop() { stopping_ = true; }

  bool standing() const { return standing_; }
  bool stopping() const { return stopping_; }
  /// Part of its time that is over, 0 to 1; it does not rise while stopping.
  double fraction() const;
  /// Remaining time to the goal, s; 0 once it stopped.
  double remaining() const;
  const Plan& plan() const { return plan_; }

 private:
  void brake(double seconds);

  Plan plan_;
  double time_ = 0;  // s since the start, until it is stopped
  double s_ = 0;
  double speed_ = 0;  // ds/dt
  bool stopping_ = false;
  bool standing_ = false;
};

}  // namespace robcl::motion
