#include "robcl/motion/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace robcl::motion {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double piece = 0.125;       // of an interval
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

/// Restricts `interval`, which is that at `x`, to the values of u for which the absolute value of
/// `acceleration` is at most `limit`.
void PathBounds::restrict(Interval& interval, const Acceleration& acceleration, double x,
                          double limit) {
  const auto [per_u, per_x] = acceleration;
  if (std::abs(per_u) <= negligible) {
    // The limit is one of x alone: where it is exceeded, the interval is empty by that excess.
    const double excess = std::abs(per_x) * x - limit;
    if (excess > 0) interval = {excess, 0, std::abs(per_x), 0};
    return;
  }
  const double end = limit / std::abs(per_u), middle_per_x = -per_x / per_u;
  interval.raise_lower(middle_per_x * x - end, middle_per_x);
  interval.reduce_upper(middle_per_x * x + end, middle_per_x);
}

double PathBounds::slope(std::size_t knot, Eigen::Index axis, double place) const {
  const Bend& bend = bends_[knot];
  return bend.slope[axis] + place * step() * (bend.curvature[axis] + place / 2 * bend.change[axis]);
}

/// Returns the acceleration at the fraction `place` of the interval. (ds/dt)² is x at the fraction
/// `part`, and x + 2·u·(place - part)·step at `place`.
PathBounds::Acceleration PathBounds::acceleration(std::size_t knot, Eigen::Index axis, double place,
                                                  double part) const {
  const double curvature = bends_[knot].curvature[axis] + place * bends_[knot].change[axis];
  return {slope(knot, axis, place) + 2 * (place - part) * step() * curvature, curvature};
}

/// Returns the middle Bézier coefficient of the acceleration between the fractions `start` and
/// `end` of the interval. The acceleration is quadratic in s there, so that it is nowhere greater
/// than the greatest of its values at both ends and this coefficient.
PathBounds::Acceleration PathBounds::between(std::size_t knot, Eigen::Index axis, double start,
                                             double end, double part) const {
  const auto one = acceleration(knot, axis, start, part);
  const auto middle = acceleration(knot, axis, (start + end) / 2, part);
  const auto other = acceleration(knot, axis, end, part);
  return {2 * middle.per_u - (one.per_u + other.per_u) / 2,
          2 * middle.per_x - (one.per_x + other.per_x) / 2};
}

PathBounds::Interval PathBounds::over_interval(std::size_t knot, double x) const {
  Interval allowed{-tool_acceleration_, tool_acceleration_};
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    for (const double place : {0.0, 0.5, 1.0}) {
      restrict(allowed, acceleration(knot, axis, place, 0), x, accelerations_[axis]);
    }
    const double halfway = std::abs(slope(knot, axis, 0.5));
    if (halfway <= negligible) continue;
    allowed.reduce_upper((squared(speeds_[axis] / halfway) - x) / step(), -1 / step());
  }
  return allowed;
}

/// Returns the values of u that the limits allow everywhere from the fraction `from` of the
/// interval to its end. (ds/dt)² is `x` at the fraction `part`.
PathBounds::Interval PathBounds::everywhere(std::size_t knot, double from, double part,
                                            double x) const {
  Interval allowed{-tool_acceleration_, tool_acceleration_};
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const double limit = accelerations_[axis];
    restrict(allowed, acceleration(knot, axis, from, part), x, limit);
    double start = from;
    for (double end = piece; end <= 1; end += piece) {
      if (end <= from) continue;
      restrict(allowed, between(knot, axis, start, end, part), x, limit);
      restrict(allowed, acceleration(knot, axis, end, part), x, limit);
      start = end;
    }
  }
  return allowed;
}

double PathBounds::excess(std::size_t knot, double x, double u) const {
  double factor = 1;
  const double after = std::max(x + 2 * u * step(), 0.0);
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const auto slowed = [&](const Acceleration& here) {
      return std::sqrt(std::abs(here.per_u * u + here.per_x * x) / accelerations_[axis]);
    };
    const auto too_fast = [&](double place) {
      const double speed = std::sqrt(x + place * (after - x));
      return std::abs(slope(knot, axis, place)) * speed / speeds_[axis];
    };
    // For nearly all intervals, the coefficients for the whole interval show that nothing exceeds
    // its limit.
    const double bend =
        std::abs(bends_[knot].curvature[axis]) + std::abs(bends_[knot].change[axis]);
    const double steepest = std::abs(bends_[knot].slope[axis]) + step() * bend;
    if (slowed(between(knot, axis, 0, 1, 0)) <= 1 && slowed(acceleration(knot, axis, 0, 0)) <= 1 &&
        slowed(acceleration(knot, axis, 1, 0)) <= 1 &&
        steepest * std::sqrt(std::max(x, after)) <= speeds_[axis]) {
      continue;
    }
    for (double end = piece; end <= 1; end += piece) {
      factor = std::max({factor, slowed(between(knot, axis, end - piece, end, 0)),
                         slowed(acceleration(knot, axis, end, 0)), too_fast(end)});
    }
  }
  return factor;
}

}  // namespace robcl::motion
