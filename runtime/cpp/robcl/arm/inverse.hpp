// Inverse kinematics: the computation of joint positions that put the flange at a wanted pose.
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

/// The interface of all solvers for inverse kinematics. Only one thread at a time may use a solver.
class InverseKinematics {
 public:
  virtual ~InverseKinematics() = default;

  /// Returns joint positions that put the flange at `base_from_flange`. The joint positions are
  /// inside the limits of the joints, and in a configuration that `wanted` admits. If there are
  /// several solutions, returns the one that the arm reaches soonest from `reference`. At a
  /// singularity, a joint that has no effect keeps its position in `reference`.
  virtual tl::expected<JointValues, Failure> solve(const Frame& base_from_flange,
                                                   const JointValues& reference,
                                                   const Configuration& wanted = {}) = 0;

  /// Returns the configuration of an arm at the joint positions `joints`. The member of the
  /// shoulder, the elbow or the wrist is empty if the arm is at the singularity of this part. All
  /// members are empty if the solver does not know configurations.
  virtual Configuration configuration(const JointValues& joints) = 0;
  /// Returns whether the solver knows configurations.
  virtual bool has_configurations() const = 0;
};

/// Makes a solver for `model`. The solver is a closed-form solver if the geometry of the arm allows
/// it and if forward kinematics confirm its solutions for test poses. Otherwise, the solver is
/// iterative: it uses KDL, and may miss solutions.
std::unique_ptr<InverseKinematics> make_inverse(const ArmModel& model);

/// Returns the shortest time in s for a move from the joint positions `from` to the joint positions
/// `to`. Assumes that all joints move at full speed.
double travel_time(const ArmModel& model, const JointValues& from, const JointValues& to);

/// Adds whole turns to `angle` and returns the sum that is inside `limits` and nearest to
/// `reference`. If no sum is inside `limits`, returns the sum that is nearest to `limits`.
double nearest_turn(double angle, double reference, const JointLimits& limits);

/// Returns the joint that is furthest outside its limits; nullopt if all joints are inside their
/// limits.
std::optional<JointLimit> first_outside(const ArmModel& model, const JointValues& joints);

}  // namespace robcl::arm
