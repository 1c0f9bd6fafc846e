// Iterative inverse kinematics for arms without a closed form: KDL's Levenberg-Marquardt solver.
#pragma once

#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/jntarray.hpp>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

/// Searches from the reference first, then from points spread evenly inside the joint limits.
/// Checks each solution by forward kinematics, because KDL reports success for some wrong ones. May
/// miss solutions (about one pose in 400), so its OutOfReach means "not found". Does not know
/// configurations.
class NumericInverse final : public InverseKinematics {
 public:
  static constexpr int starts = 24;

  explicit NumericInverse(const ArmModel& model);

  /// Fails unless all members of `wanted` are empty.
  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues&) override { return {}; }

 private:
  JointValues start(int attempt, const JointValues& reference) const;

  ArmModel model_;
  Kinematics forward_;
  KDL::Chain chain_;  // solver_ keeps a reference to this chain
  KDL::ChainIkSolverPos_LMA solver_;
};

}  // namespace robcl::arm
