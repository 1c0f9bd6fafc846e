#include "robcl/motion/bounds.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace robcl::motion {
namespace {

constexpr double piece = 0.125;       // length of a piece, as a fraction of an interval
constexpr double negligible = 1e-12;  // rad or m: a smaller movement on the path sets no limit

}  // namespace

PathBounds::PathBounds(const Path& path, const arm::ArmModel& model,
                       const std::vector<IntervalLimits>& limits)
    : accelerations_(model.axes()),
      speeds_(model.axes()),
      places_(path.places()),
      caps_(places_.size(), infinite) {
  assert(limits.size() == path.intervals());
  for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
    const auto& of_joint = model.limits()[static_cast<std::size_t>(axis)];
    accelerations_[axis] = of_joint.acceleration;
    speeds_[axis] = of_joint.speed;
  }
  stretches_.reserve(path.intervals());
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    cap(i, path.slope(i), limits[i]);
    cap(i + 1, path.slope(i + 1), limits[i]);
    const JointValues curvature = path.derivatives(i, 0).curvature;
    stretches_.push_back(
        {path.slope(i), curvature, path.derivatives(i, 1).curvature - curvature, limits[i]});
  }
}

/// Lowers the cap of (ds/dt)² at the knot `knot` to the value that `limits` allow there. `limits`
/// are the limits of an interval beside the knot, and `slope` is the slope of the path at the knot.
void PathBounds::cap(std::size_t knot, const JointValues& slope, const IntervalLimits& limits) {
  double& cap = caps_[knot];
  cap = std::min(cap, limits.cap);
  for (Eigen::Index axis = 0; axis < speeds_.size(); ++axis) {
    const double way = std::abs(slope[axis]);
    if (way > negligible) cap = std::min(cap, squared(limits.speed * speeds_[axis] / way));
  }
}

void PathBounds::tighten(std::size_t knot, double factor) {
  IntervalLimits& limits = stretches_[knot].limits;
  limits.speed /= factor;
  limits.acceleration /= squared(factor);
  for (const std::size_t end : {knot, knot + 1}) caps_[end] /= squared(factor);
}

/// Restricts `interval`, the allowed values of u = d²s/dt² where (ds/dt)² is `x`, to the values for
/// which the absolute value of `acceleration` is at most `limit`.
void PathBounds::restrict(Interval& interval, const Acceleration& acceleration, double x,
                          double limit) {
  const auto [per_u, per_x] = acceleration;
  if (std::abs(per_u) <= negligible) {
    // The limit depends on x only. If x exceeds the limit, no u is allowed. To make the interval
    // empty, its lower end is set above its upper end, by the excess.
    const double excess = std::abs(per_x) * x - limit;
    if (excess > 0) interval = {excess, 0, std::abs(per_x), 0};
    return;
  }
  const double end = limit / std::abs(per_u), middle_per_x = -per_x / per_u;
  interval.raise_lower(middle_per_x * x - end, middle_per_x);
  interval.reduce_upper(middle_per_x * x + end, middle_per_x);
}

double PathBounds::slope(std::size_t knot, Eigen::Index axis, double place) const {
  const Stretch& here = stretches_[knot];
  return here.slope[axis] +
         place * step(knot) * (here.curvature[axis] + place / 2 * here.change[axis]);
}

double PathBounds::acceleration_limit(std::size_t knot, Eigen::Index axis) const {
  return accelerations_[axis] * stretches_[knot].limits.acceleration;
}

/// Returns the acceleration of the joint `axis` at the fraction `place` of the interval. In the
/// result, x is (ds/dt)² at the fraction `part`. At `place`, (ds/dt)² is x + 2·u·(place -
/// part)·step.
PathBounds::Acceleration PathBounds::acceleration(std::size_t knot, Eigen::Index axis, double place,
                                                  double part) const {
  const Stretch& here = stretches_[knot];
  const double curvature = here.curvature[axis] + place * here.change[axis];
  return {slope(knot, axis, place) + 2 * (place - part) * step(knot) * curvature, curvature};
}

/// Returns the middle Bézier coefficient of the acceleration between the fractions `start` and
/// `end` of the interval. The acceleration is quadratic in s. Therefore it is nowhere greater than
/// the greatest of three values: this coefficient, and the acceleration at both ends.
PathBounds::Acceleration PathBounds::between(std::size_t knot, Eigen::Index axis, double start,
                                             double end, double part) const {
  const auto one = acceleration(knot, axis, start, part);
  const auto middle = acceleration(knot, axis, (start + end) / 2, part);
  const auto other = acceleration(knot, axis, end, part);
  return {2 * middle.per_u - (one.per_u + other.per_u) / 2,
          2 * middle.per_x - (one.per_x + other.per_x) / 2};
}

/// Returns the values of u = d²s/dt² that the limits of the tool allow on the rest of the interval:
/// from the fraction `part`, where (ds/dt)² is `x`, to the end of the interval.
PathBounds::Interval PathBounds::of_tool(std::size_t knot, double part, double x) const {
  Interval allowed{-infinite, infinite};
  const IntervalLimits& limits = stretches_[knot].limits;
  for (const IntervalLimits::Tool& tool : {limits.way, limits.turn}) {
    if (tool.limit == infinite) continue;
    for (const double place : {part, 1.0}) {
      const double way = 2 * (place - part) * step(knot);  // from where x is given
      restrict(allowed, {tool.per_u + tool.per_x * way, tool.per_x}, x, tool.limit);
      restrict(allowed, {tool.per_u - tool.per_x * way, -tool.per_x}, x, tool.limit);
      if (tool.per_x == 0) break;
    }
  }
  return allowed;
}

PathBounds::Interval PathBounds::over_interval(std::size_t knot, double x) const {
  Interval allowed = of_tool(knot, 0, x);
  const IntervalLimits& limits = stretches_[knot].limits;
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    for (const double place : {0.0, 0.5, 1.0}) {
      restrict(allowed, acceleration(knot, axis, place, 0), x, acceleration_limit(knot, axis));
    }
    const double halfway = std::abs(slope(knot, axis, 0.5));
    if (halfway <= negligible) continue;
    const double cap = squared(limits.speed * speeds_[axis] / halfway);
    allowed.reduce_upper((cap - x) / step(knot), -1 / step(knot));
  }
  return allowed;
}

PathBounds::Interval PathBounds::over_rest(std::size_t knot, double part, double x) const {
  Interval allowed = of_tool(knot, part, x);
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const double limit = acceleration_limit(knot, axis);
    restrict(allowed, acceleration(knot, axis, part, part), x, limit);
    double start = part;
    for (double end = piece; end <= 1; end += piece) {
      if (end <= part) continue;
      restrict(allowed, between(knot, axis, start, end, part), x, limit);
      restrict(allowed, acceleration(knot, axis, end, part), x, limit);
      start = end;
    }
  }
  return allowed;
}

double PathBounds::acceleration_limit(std::size_t knot) const {
  const Stretch& here = stretches_[knot];
  double limit = infinite;
  for (const IntervalLimits::Tool& tool : {here.limits.way, here.limits.turn}) {
    if (tool.per_u > negligible) limit = std::min(limit, tool.limit / tool.per_u);
  }
  if (limit < infinite) return limit;
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const double way = std::abs(here.slope[axis]);
    if (way > negligible) limit = std::min(limit, acceleration_limit(knot, axis) / way);
  }
  return limit;
}

double PathBounds::excess(std::size_t knot, double x, double u) const {
  double factor = 1;
  const Stretch& here = stretches_[knot];
  const double after = std::max(x + 2 * u * step(knot), 0.0);
  for (Eigen::Index axis = 0; axis < accelerations_.size(); ++axis) {
    const double fastest = here.limits.speed * speeds_[axis];
    const auto slowed = [&](const Acceleration& at) {
      return std::sqrt(std::abs(at.per_u * u + at.per_x * x) / acceleration_limit(knot, axis));
    };
    const auto too_fast = [&](double place) {
      const double speed = std::sqrt(x + place * (after - x));
      return std::abs(slope(knot, axis, place)) * speed / fastest;
    };
    // For nearly all intervals, this check of the whole interval shows that the joint keeps its
    // limits, so that the pieces of the interval need no check.
    const double bend = std::abs(here.curvature[axis]) + std::abs(here.change[axis]);
    const double steepest = std::abs(here.slope[axis]) + step(knot) * bend;
    if (slowed(between(knot, axis, 0, 1, 0)) <= 1 && slowed(acceleration(knot, axis, 0, 0)) <= 1 &&
        slowed(acceleration(knot, axis, 1, 0)) <= 1 &&
        steepest * std::sqrt(std::max(x, after)) <= fastest) {
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
