#pragma once

#include <vector>

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Lets joints follow a moving target, and keeps the limits of their positions, speeds and
/// accelerations whatever the target does. While the target keeps them too, the joints are at the
/// target in each cycle; after a jump of the target they catch up as fast as they can, each joint
/// by itself. Never allocates memory after it was made.
///
/// The law is that of R. Zanasi, C. Guarino Lo Bianco and A. Tonielli, "Nonlinear filters for the
/// generation of smooth trajectories", 2000, with the stopping distance counted in whole cycles.
class JointLimiter {
 public:
  /// The joints stand at `start`, inside `limits`.
  JointLimiter(std::vector<arm::JointLimits> limits, const JointValues& start);

  /// Moves the target by one cycle of `cycle` seconds, and returns the positions of the joints.
  const JointValues& follow(const JointValues& target, double cycle);
  /// Returns the positions at which the joints stand soonest, inside their limits.
  JointValues stop(double cycle) const;
  /// The joints and the target stand where the joints are.
  void rest();

  const JointValues& joints() const { return joints_; }
  /// Whether all joints are at the target.
  bool at_target() const { return joints_ == target_; }
  /// Whether each joint is at the target but for what its acceleration does in one cycle.
  bool near_target(double cycle) const;
  bool at_rest() const { return speeds_.isZero(0); }

 private:
  void follow(Eigen::Index axis, double target, double cycle);

  std::vector<arm::JointLimits> limits_;
  JointValues joints_, target_;  // rad
  JointValues speeds_;           // rad/s, in the last cycle
};

}  // namespace robcl::motion
