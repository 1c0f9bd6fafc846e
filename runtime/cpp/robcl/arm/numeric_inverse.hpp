// The inverse of arms without a closed form: KDL's Levenberg-Marquardt, from several starts.
#pragma once

#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/jntarray.hpp>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"

namespace robcl::arm {

/// Starts at the reference, then at points spread evenly inside the joint limits; each answer is
/// checked by FK, because the solver calls some wrong ones good. It may miss solutions (about one
/// pose in four hundred), knows no configurations, and its OutOfReach means "not found".
class NumericInverse final : public InverseKinematics {
 public:
  static constexpr int starts = 24;

  explicit NumericInverse(const ArmModel& model);

  /// Refuses every `wanted` that asks for something.
  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues&) override { return {}; }

 private:
  JointValues start(int attempt, const JointValues& reference) const;

  ArmModel model_;
  Kinematics forward_;
  KDL::Chain chain_;  // the solver keeps a reference to it
  KDL::ChainIkSolverPos_LMA solver_;
};

}  // namespace robcl::arm
