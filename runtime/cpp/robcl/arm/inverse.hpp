// Inverse: from where the flange shall be to joint positions.
#pragma once

#include <memory>
#include <optional>

#include "gecos/base/result.hpp"
#include "robcl/arm/configuration.hpp"
#include "robcl/arm/failure.hpp"
#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// The contract of all solvers. One thread at a time.
class InverseKinematics {
 public:
  virtual ~InverseKinematics() = default;

  /// Joint positions inside the limits, in a configuration that `wanted` admits, that the arm
  /// reaches soonest from `reference`. A joint that does not matter (at a singularity) stays where
  /// it is.
  virtual tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                                   const JointValues& reference,
                                                   const Configuration& wanted = {}) = 0;

  /// The configuration of the arm. Empty members at a singularity, or where the solver has no such
  /// notion.
  virtual Configuration configuration(const JointValues& joints) = 0;
};

/// The closed form where the arm's geometry allows it, verified by FK(IK) before it is given out,
/// else KDL's iterative solver, which may miss solutions.
std::unique_ptr<InverseKinematics> make_inverse(const ArmModel& model);

/// Time that an arm needs at least from one place to the other, all joints at full speed, s.
double travel_time(const ArmModel& model, const JointValues& from, const JointValues& to);

/// The copy of `angle` by whole turns that lies inside the limits and nearest `reference`; the one
/// least outside when none is inside.
double nearest_turn(double angle, double reference, const JointLimits& limits);

/// The joint furthest outside its limits, if any is.
std::optional<JointLimit> first_outside(const ArmModel& model, const JointValues& joints);

}  // namespace robcl::arm
