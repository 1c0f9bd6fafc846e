#pragma once

#include <optional>

#include "robcl/arm/failure.hpp"
#include "robcl/arm/inverse.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Follows a path of poses in small steps, by the inverse kinematics. The arm keeps the
/// configuration in which it starts, and no joint makes a whole turn from one step to the next.
class PoseWalk {
 public:
  PoseWalk(const arm::ArmModel& model, arm::InverseKinematics& inverse, const JointValues& from)
      : model_(model), inverse_(inverse), at_{from, inverse.configuration(from)} {}

  /// The present place of the walk.
  struct Place {
    JointValues joints;
    arm::Configuration kept;
  };
  const Place& at() const { return at_; }
  void return_to(const Place& place) { at_ = place; }

  /// Steps to the joint positions that put the flange at `base_from_flange`. If no such joint
  /// positions are inside the limits, returns the reason and does not move.
  std::optional<arm::Failure> step_to(const Frame& base_from_flange);

 private:
  const arm::ArmModel& model_;
  arm::InverseKinematics& inverse_;
  Place at_;
};

}  // namespace robcl::motion
