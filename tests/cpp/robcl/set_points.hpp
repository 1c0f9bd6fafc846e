// What tests check of the set points that an arm's driver receives.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "robcl/arm/kinematics.hpp"
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

/// Returns the flange at each set point.
inline std::vector<Frame> flanges_at(const arm::ArmModel& model,
                                     const std::vector<arm::JointValues>& all) {
  arm::Kinematics forward(model);
  std::vector<Frame> flanges;
  flanges.reserve(all.size());
  for (const arm::JointValues& joints : all) flanges.push_back(forward.base_from_flange(joints));
  return flanges;
}

/// Returns how far `at` is from the straight line between two points.
template <class Point>
double off_line(const Point& at, const Point& from, const Point& to) {
  const Point way = at - from, line = to - from;
  const double part = std::clamp(way.dot(line) / line.squaredNorm(), 0.0, 1.0);
  return (way - part * line).norm();
}

/// Checks that the tool is no further than .05 mm from the line between two positions.
/// `tools`: the tool at each set point.
inline void expect_on_line(const std::vector<Frame>& tools, const Eigen::Vector3d& from,
                           const Eigen::Vector3d& to) {
  for (std::size_t k = 0; k < tools.size(); ++k) {
    ASSERT_LE(off_line<Eigen::Vector3d>(tools[k].position(), from, to), 5e-5)
        << "distance to the line in cycle " << k << " of " << tools.size();
  }
}

/// Checks speed and acceleration of the tool, which turns about one axis. `tools`: the tool at each
/// set point.
inline void expect_tool_within_limits(const std::vector<Frame>& tools, const ToolLimits& limits,
                                      double period) {
  for (std::size_t k = 1; k + 1 < tools.size(); ++k) {
    const Frame &before = tools[k - 1], &now = tools[k], &after = tools[k + 1];
    const double turned = angle(before, now), turns = angle(now, after);
    const Eigen::Vector3d change = after.position() - 2 * now.position() + before.position();
    ASSERT_LE(distance(before, now) / period, limits.speed * slack) << "in cycle " << k;
    ASSERT_LE(change.norm() / (period * period), limits.acceleration * slack) << "in cycle " << k;
    ASSERT_LE(turned / period, limits.turn_speed * slack) << "in cycle " << k;
    ASSERT_LE(std::abs(turns - turned) / (period * period), limits.turn_acceleration * slack)
        << "in cycle " << k << " of " << tools.size();
  }
}

}  // namespace robcl::motion
