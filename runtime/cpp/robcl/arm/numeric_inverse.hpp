// Iterative inverse kinematics for arms without a closed form: KDL's Levenberg-Marquardt solver.
#pragma once

#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/jntarray.hpp>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

/// A solver that searches for a solution. It starts at the reference, and then at points that are
/// spread evenly inside the joint limits. It checks each solution by forward kinematics, because
/// KDL reports success for some wrong solutions. It finds no solution for about one reachable pose
/// in 400; its error OutOfReach therefore means only that no solution was found. It does not know
/// configurations.
class NumericInverse final : public InverseKinematics {
 public:
  static constexpr int starts = 24;

  explicit NumericInverse(const ArmModel& model);

  /// Finds a solution. Fails if a member of `wanted` is not empty.
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
