#pragma once

#include <vector>

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Lets joints follow a moving target, and keeps the limits of their positions, speeds and
/// accelerations whatever the target does. While the target keeps the limits too, the joints are at
/// the target in each cycle. After a jump of the target, each joint catches up as fast as it can.
/// The constructor allocates all memory.
///
/// The law is that of R. Zanasi, C. Guarino Lo Bianco and A. Tonielli, "Nonlinear filters for the
/// generation of smooth trajectories", 2000, with the stopping distance counted in whole cycles.
class JointLimiter {
 public:
  /// @pre the joints stand at `start`, which is inside `limits`.
  JointLimiter(std::vector<arm::JointLimits> limits, const JointValues& start);

  /// Moves the joints for one cycle of `cycle` seconds towards `target`, and returns the positions
  /// of the joints.
  const JointValues& follow(const JointValues& target, double cycle);
  /// Returns the positions, inside the limits, at which the joints come to rest soonest.
  JointValues stop(double cycle) const;
  /// Sets the speeds of the joints to zero, and makes their present positions the target.
  void rest();

  const JointValues& joints() const { return joints_; }
  /// Returns whether all joints are at the target.
  bool at_target() const { return joints_ == target_; }
  /// Returns whether each joint is near the target. Near means not further away than the distance
  /// by which full acceleration changes the position of the joint in one cycle.
  bool near_target(double cycle) const;
  bool at_rest() const { return speeds_.isZero(0); }

 private:
  void follow(Eigen::Index axis, double target, double cycle);

  std::vector<arm::JointLimits> limits_;
  JointValues joints_, target_;  // rad
  JointValues speeds_;           // rad/s, in the last cycle
};

}  // namespace robcl::motion
