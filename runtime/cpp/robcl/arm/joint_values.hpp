#pragma once

#include <Eigen/Core>

namespace robcl::arm {

/// Largest number of joints of an arm; loading an arm with more joints fails.
inline constexpr int max_axes = 8;

/// One value per joint, rad (or rad/s, rad/s²). Stored inside the object: never allocates.
using JointValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_axes, 1>;

/// Column i: twist of the flange, seen from the base, per rad/s of joint i; three rows in m/s, then
/// three in rad/s.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, max_axes>;

struct JointLimits {
  double lower = 0;         ///< rad
  double upper = 0;         ///< rad
  double speed = 0;         ///< rad/s
  double acceleration = 0;  ///< rad/s²
};

}  // namespace robcl::arm
