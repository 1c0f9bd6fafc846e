#pragma once

#include <optional>
#include <string>

#include "robcl/frames/units.hpp"

namespace robcl::motion {

/// The limits of the tool on a straight line. They apply in addition to the limits of the joints.
struct ToolLimits {
  double speed = 1.0;                   ///< m/s
  double acceleration = 3.0;            ///< m/s²
  double turn_speed = deg(180);         ///< rad/s
  double turn_acceleration = deg(720);  ///< rad/s²
};

/// The limits that a caller requests for a move. The arm keeps all of them, so that the lowest
/// limit determines the motion.
struct Pace {
  double speed = 1;                    ///< fraction of the robot's maximum, above 0, at most 1
  double acceleration = 1;             ///< fraction of the robot's maximum, above 0, at most 1
  std::optional<double> tool_speed{};  ///< m/s, at least 1e-6
  std::optional<double> turn_speed{};  ///< rad/s, at least 1e-6
  /// Accelerations along a straight line; a joint move has none of them.
  std::optional<double> tool_acceleration{};  ///< m/s², at least 1e-6
  std::optional<double> turn_acceleration{};  ///< rad/s², at least 1e-6
};

/// Returns an error text if `pace` is invalid; nullopt if it is valid.
std::optional<std::string> problem_of(const Pace& pace);
/// Returns an error text if `pace` is invalid for a joint move; nullopt if it is valid.
std::optional<std::string> problem_of_joint_move(const Pace& pace);

}  // namespace robcl::motion
