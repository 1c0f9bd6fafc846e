#include "robcl/motion/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace robcl::motion {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double halfway = 0.5;       // of an interval
constexpr double negligible = 1e-12;  // rad or m: a smaller movement on the path sets no limit

double squared(double value) { return value * value; }

}  // namespace

PathBounds::PathBounds(const Path& path, const arm::ArmModel& model, const Pace& pace)
    : accelerations_(model.axes()), speeds_(model.axes()), tool_acceleration_(infinite) {
  for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
    const auto& limits = model.limits()[static_cast<std::size_t>(axis)];
    accelerations_[axis] = limits.acceleration * pace.acceleration;
    speeds_[axis] = limits.speed * pace.speed;
  }
  caps_.assign(path.intervals() + 1, infinite);
  for (std::size_t i = 0; i <= path.intervals(); ++i) {
    for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
      const double slope = std::abs(path.slope(i)[axis]);
      if (slope > negligible) cap(i, squared(speeds_[axis] / slope));
    }
  }
  bends_.reserve(path.intervals());
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    const JointValues curvature = path.derivatives(i, 0).curvature;
    bends_.push_back({path.slope(i), curvature, path.derivatives(i, 1).curvature - curvature});
  }
}

void PathBounds::add_tool(double length, double turn, const ToolLimits& limits, const Pace& pace) {
  const double speed = std::min(limits.speed * pace.speed, pace.tool_speed.value_or(infinite));
  const double turning =
      std::min(limits.turn_speed * pace.speed, pace.turn_speed.value_or(infinite));
  double fastest = infinite;
  if (length > negligible) {
    fastest = std::min(fastest, speed / length);
    tool_acceleration_ =
        std::min(tool_acceleration_, limits.acceleration * pace.acceleration / length);
  }
  if (turn > negligible) {
    fastest = std::min(fastest, turning / turn);
    tool_acceleration_ =
        std::min(tool_acceleration_, limits.turn_acceleration * pace.acceleration / turn);
  }
  for (std::size_t i = 0; i < caps_.size(); ++i) cap(i, squared(fastest));
}

void PathBounds::cap(std::size_t knot, double fastest) {
  caps_[knot] = std::min(caps_[knot], fastest);
}

/// Restricts `interval` to the values of u for which |per_u·u + offset| <= limit holds.
void PathBounds::restrict(Interval& interval, double per_u, double offset, double limit) {
  if (std::abs(per_u) <= negligible) {
    if (std::abs(offset) > limit) interval = {1, -1};
    return;
  }
  const double one = (limit - offset) / per_u, other = (-limit - offset) / per_u;
  interval.lower = std::max(interval.lower, std::min(one, other));
  interval.upper = std::min(interval.upper, std::max(one, other));
}

PathBounds::Interval PathBounds::over_interval(std::size_t knot, double x, double part) const {
  Interval allowed{-tool_acceleration_, tool_acceleration_};
  const Bend& bend = bends_[knot];
  for (const double place : {part, halfway, 1.0}) {
    if (place < part) continue;
    const double per_u = 2 * (place - part) * step();  // (ds/dt)² is x + per_u·u at this place
    for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
      const double curvature = bend.curvature[axis] + place * bend.change[axis];
      const double slope = bend.slope[axis] +
                           place * step() * (bend.curvature[axis] + place / 2 * bend.change[axis]);
      restrict(allowed, slope + per_u * curvature, curvature * x, accelerations_[axis]);
      if (place == halfway && per_u > 0 && std::abs(slope) > negligible) {
        allowed.upper = std::min(allowed.upper, (squared(speeds_[axis] / slope) - x) / per_u);
      }
    }
  }
  return allowed;
}

}  // namespace robcl::motion
