// What tests check of the set points that an arm's driver receives.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/pace.hpp"

namespace robcl::motion {

constexpr double slack = 1.001;

/// `all`: the set points, one for each `period` in s.
inline void expect_within_limits(const arm::ArmModel& model,
                                 const std::vector<arm::JointValues>& all, const Pace& pace,
                                 double period) {
  for (std::size_t k = 1; k + 1 < all.size(); ++k) {
    for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
      const auto& limits = model.limits()[static_cast<std::size_t>(axis)];
      const double speed = std::abs(all[k][axis] - all[k - 1][axis]) / period;
      const double acceleration =
          std::abs(all[k + 1][axis] - 2 * all[k][axis] + all[k - 1][axis]) / (period * period);
      ASSERT_LE(speed, limits.speed * pace.speed * slack) << "joint " << axis + 1;
      ASSERT_LE(acceleration, limits.acceleration * pace.acceleration * slack)
          << "joint " << axis + 1 << " in cycle " << k << " of " << all.size();
      ASSERT_GE(all[k][axis], limits.lower - 1e-9);
      ASSERT_LE(all[k][axis], limits.upper + 1e-9);
    }
  }
}

/// Checks that the acceleration of a joint rises to its limit in no less than `rise` s.
inline void expect_limited_jerk(const arm::ArmModel& model,
                                const std::vector<arm::JointValues>& all, double rise,
                                double period) {
  for (std::size_t k = 3; k < all.size(); ++k) {
    for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
      const double limit = model.limits()[static_cast<std::size_t>(axis)].acceleration / rise;
      const double third =
          all[k][axis] - 3 * all[k - 1][axis] + 3 * all[k - 2][axis] - all[k - 3][axis];
      ASSERT_LE(std::abs(third) / (period * period * period), limit * slack)
          << "jerk of joint " << axis + 1 << " in cycle " << k << " of " << all.size();
    }
  }
}

}  // namespace robcl::motion
