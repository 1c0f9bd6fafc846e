// Inverse kinematics: joint positions that put the flange at a wanted pose.
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

/// The interface of all inverse kinematics solvers. Used by one thread at a time.
class InverseKinematics {
 public:
  virtual ~InverseKinematics() = default;

  /// Considers the joint positions inside the limits and in a configuration that `wanted` admits.
  /// Returns those that the arm reaches soonest from `reference`. At a singularity, a joint without
  /// effect keeps its position in `reference`.
  virtual tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                                   const JointValues& reference,
                                                   const Configuration& wanted = {}) = 0;

  /// The configuration of an arm at `joints`. Members are empty at a singularity; all are empty if
  /// the solver does not know configurations.
  virtual Configuration configuration(const JointValues& joints) = 0;
};

/// Makes the closed-form solver if the arm's geometry allows it and forward kinematics of its
/// solutions reproduces test poses, else KDL's iterative solver, which may miss solutions.
std::unique_ptr<InverseKinematics> make_inverse(const ArmModel& model);

/// Shortest time from the joint positions `from` to `to`, s: all joints move at full speed.
double travel_time(const ArmModel& model, const JointValues& from, const JointValues& to);

/// Adds whole turns to `angle`: returns the sum inside the limits that is nearest to `reference`,
/// or, if no sum is inside, the one least outside.
double nearest_turn(double angle, double reference, const JointLimits& limits);

/// The joint that is furthest outside its limits; nullopt if all joints are inside.
std::optional<JointLimit> first_outside(const ArmModel& model, const JointValues& joints);

}  // namespace robcl::arm
