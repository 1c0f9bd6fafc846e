#pragma once

#include <Eigen/Core>

namespace robcl::arm {

/// Arms with more joints than this are refused when they are loaded.
inline constexpr int max_axes = 8;

/// One number per joint, rad (or rad/s, rad/s²). Lives where it is declared: never allocates.
using JointValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_axes, 1>;

/// Twist of the flange (m/s, then rad/s, seen from the base) per joint speed.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, max_axes>;

struct JointLimits {
  double lower = 0;         ///< rad
  double upper = 0;         ///< rad
  double speed = 0;         ///< rad/s
  double acceleration = 0;  ///< rad/s²
};

}  // namespace robcl::arm
