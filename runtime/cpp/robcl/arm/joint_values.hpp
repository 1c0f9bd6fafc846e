#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace robcl::arm {

/// The largest number of joints of an arm. Loading the model of an arm with more joints fails.
inline constexpr int max_axes = 8;

/// One value for each joint, in rad, rad/s or rad/s². The values are stored inside the object. No
/// function allocates memory.
using JointValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_axes, 1>;

/// A Jacobian matrix. Column i is the twist of the flange, seen from the base, for a speed of 1
/// rad/s of joint i. The first three rows are in m/s, and the other three rows in rad/s.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, max_axes>;

struct JointLimits {
  double lower = 0;         ///< rad
  double upper = 0;         ///< rad
  double speed = 0;         ///< rad/s
  double acceleration = 0;  ///< rad/s²
};

/// Returns `angle` plus the whole turns that bring it nearest to `reference`. All angles are in
/// rad.
inline double nearest_angle(double angle, double reference) {
  const double away = angle - reference;
  if (std::abs(away) <= std::numbers::pi) return angle;  // std::remainder takes 20 times as long
  return reference + std::remainder(away, 2 * std::numbers::pi);
}

}  // namespace robcl::arm
