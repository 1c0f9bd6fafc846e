// Iterative inverse kinematics for arms without a closed form.
#pragma once

#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/jntarray.hpp>
#include <optional>
#include <string>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/local_inverse.hpp"

namespace robcl::arm {

/// A solver that searches for a solution. It first searches near the reference by LocalInverse, so
/// that small steps of the pose lead to small steps of the joints. Then it starts KDL's solver from
/// points that are spread evenly inside the joint limits. It checks and refines each solution of
/// KDL's solver, because some of them are wrong. For a few reachable poses, 8 of 10,000 of a
/// seven-axis arm, the search finds no solution. The error OutOfReach therefore means only that no
/// solution was found. This solver does not know configurations.
class NumericInverse final : public InverseKinematics {
 public:
  static constexpr int starts = 24;

  explicit NumericInverse(const ArmModel& model);

  /// Finds a solution. Fails if a member of `wanted` is not empty.
  tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                           const JointValues& reference,
                                           const Configuration& wanted) override;
  Configuration configuration(const JointValues&) override { return {}; }
  bool has_configurations() const override { return false; }

 private:
  JointValues start(int attempt, const JointValues& reference) const;
  std::optional<JointValues> refined(const Frame& base_from_flange, JointValues joints) const;
  std::string why_out_of_reach(const Frame& base_from_flange) const;

  ArmModel model_;
  LocalInverse local_;
  KDL::Chain chain_;  // solver_ keeps a reference to this chain
  KDL::ChainIkSolverPos_LMA solver_;
};

}  // namespace robcl::arm
