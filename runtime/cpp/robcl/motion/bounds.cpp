#include "robcl/motion/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace robcl::motion {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double negligible = 1e-12;  // rad or m: a smaller movement on the path sets no limit

double squared(double value) { return value * value; }

}  // namespace

PathBounds::PathBounds(const Path& path, const arm::ArmModel& model, const Pace& pace)
    : accelerations_(model.axes()), tool_acceleration_(infinite) {
  for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
    const auto& limits = model.limits()[static_cast<std::size_t>(axis)];
    accelerations_[axis] = limits.acceleration * pace.acceleration;
  }
  const std::size_t knots = path.intervals() + 1;
  caps_.assign(knots, infinite);
  slopes_.reserve(knots);
  curvatures_.reserve(knots);
  for (std::size_t i = 0; i < knots; ++i) {
    slopes_.push_back(path.slope(i));
    curvatures_.push_back(path.curvature(i));
    for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
      const double slope = std::abs(slopes_[i][axis]);
      const double speed = model.limits()[static_cast<std::size_t>(axis)].speed * pace.speed;
      if (slope > negligible) cap(i, squared(speed / slope));
    }
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
void PathBounds::restrict(Interval& interval, double per_u, double offset, double limit) const {
  if (std::abs(per_u) <= negligible) {
    if (std::abs(offset) > limit) interval = {1, -1};
    return;
  }
  const double one = (limit - offset) / per_u, other = (-limit - offset) / per_u;
  interval.lower = std::max(interval.lower, std::min(one, other));
  interval.upper = std::min(interval.upper, std::max(one, other));
}

void PathBounds::restrict_joints(Interval& interval, std::size_t knot, double x,
                                 double u_in_x) const {
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const double curvature = curvatures_[knot][axis];
    restrict(interval, slopes_[knot][axis] + u_in_x * curvature, curvature * x,
             accelerations_[axis]);
  }
}

PathBounds::Interval PathBounds::at_knot(std::size_t knot, double x) const {
  Interval allowed{-tool_acceleration_, tool_acceleration_};
  restrict_joints(allowed, knot, x, 0);
  return allowed;
}

PathBounds::Interval PathBounds::over_interval(std::size_t knot, double x) const {
  Interval allowed = at_knot(knot, x);
  restrict_joints(allowed, knot + 1, x, 2 * step());
  return allowed;
}

PathBounds::Interval PathBounds::near(double s, double x) const {
  const double along = std::clamp(s, 0.0, 1.0) * static_cast<double>(intervals());
  const std::size_t knot = std::min(static_cast<std::size_t>(along), intervals() - 1);
  Interval allowed = at_knot(knot, x);
  restrict_joints(allowed, knot + 1, x, 0);
  return allowed;
}

}  // namespace robcl::motion
