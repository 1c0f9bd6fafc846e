#include "robcl/motion/path.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "robcl/arm/inverse.hpp"

namespace robcl::motion {

Path::Path(Knots knots) : knots_(std::move(knots)) {
  assert(knots_.places.size() >= 2 && knots_.places.size() == knots_.joints.size());
  const std::size_t last = intervals();
  slopes_.resize(last + 1);
  for (std::size_t i = 0; i <= last; ++i) slopes_[i] = slope_from_knots(i);
  std::ranges::copy(knots_.first_slopes, slopes_.begin());
}

/// Returns the derivative at the knot `i` of a polynomial through this knot and up to two knots on
/// each side of it. Inside an evenly spaced path, the derivative is accurate to fourth order; at
/// the ends of the path, to second order.
JointValues Path::slope_from_knots(std::size_t i) const {
  const std::size_t from = std::max<std::size_t>(2, i) - 2, to = std::min(intervals(), i + 2);
  const double here = place(i);
  JointValues slope = JointValues::Zero(knot(i).size());
  for (std::size_t j = from; j <= to; ++j) {
    if (j == i) continue;
    double weight = 1 / (place(j) - here);  // of the difference to the knot j
    for (std::size_t k = from; k <= to; ++k) {
      if (k != i && k != j) weight *= (here - place(k)) / (place(j) - place(k));
    }
    slope += weight * (knot(j) - knot(i));
  }
  return slope;
}

std::size_t Path::interval_at(double s) const {
  const auto inner = knots_.places.begin() + 1;
  const auto after = std::upper_bound(inner, knots_.places.end() - 1, s);
  return static_cast<std::size_t>(after - inner);
}

Path::Derivatives Path::derivatives(std::size_t interval, double part) const {
  const std::size_t i = interval;
  const double t = part;
  const JointValues chord = (knot(i + 1) - knot(i)) / step(i);
  return {6 * t * (1 - t) * chord + (1 - t) * (1 - 3 * t) * slopes_[i] +
              t * (3 * t - 2) * slopes_[i + 1],
          (6 * (1 - 2 * t) * chord + (6 * t - 4) * slopes_[i] + (6 * t - 2) * slopes_[i + 1]) /
              step(i)};
}

Path::Range Path::range(std::size_t i) const {
  Range range{knot(i).cwiseMin(knot(i + 1)), knot(i).cwiseMax(knot(i + 1))};
  for (Eigen::Index axis = 0; axis < knot(i).size(); ++axis) {
    // The position at the fraction t is knot + t·(b + t·(c + t·d)).
    const double chord = knot(i + 1)[axis] - knot(i)[axis];
    const double b = step(i) * slopes_[i][axis], after = step(i) * slopes_[i + 1][axis];
    const double c = 3 * chord - 2 * b - after, d = b + after - 2 * chord;
    const double root = std::sqrt(std::max(c * c - 3 * b * d, 0.0));
    // The zeros of the derivative b + 2ct + 3dt². Each zero is computed by two formulas, because
    // rounding spoils one of the two.
    for (const double t :
         {(-c + root) / (3 * d), (-c - root) / (3 * d), b / (-c - root), b / (-c + root)}) {
      if (!(t > 0 && t < 1)) continue;
      const double there = knot(i)[axis] + t * (b + t * (c + t * d));
      range.lowest[axis] = std::min(range.lowest[axis], there);
      range.highest[axis] = std::max(range.highest[axis], there);
    }
  }
  return range;
}

namespace {

/// Returns by how much each joint is beyond its limits, in rad: above 0 beyond the upper limit,
/// below 0 beyond the lower limit, 0 between them.
JointValues beyond_limits(const arm::ArmModel& model, const JointValues& joints) {
  JointValues beyond(joints.size());
  for (Eigen::Index axis = 0; axis < joints.size(); ++axis) {
    const arm::JointLimits& limits = model.limits()[static_cast<std::size_t>(axis)];
    beyond[axis] = joints[axis] - std::clamp(joints[axis], limits.lower, limits.upper);
  }
  return beyond;
}

/// Returns the joint that is furthest outside its limits in `range`; nullopt if there is none. A
/// joint may be beyond a limit by as much as `allowance` says, in the form of beyond_limits().
std::optional<arm::JointLimit> outside_in(const arm::ArmModel& model, const Path::Range& range,
                                          const JointValues& allowance) {
  std::optional<arm::JointLimit> worst;
  double by = 2e-9;  // rad, because of rounding
  for (Eigen::Index axis = 0; axis < allowance.size(); ++axis) {
    const arm::JointLimits& limits = model.limits()[static_cast<std::size_t>(axis)];
    const double lowest = range.lowest[axis], highest = range.highest[axis];
    const double below = limits.lower + std::min(allowance[axis], 0.0) - lowest;
    const double above = highest - limits.upper - std::max(allowance[axis], 0.0);
    const double outside = std::max(below, above);
    if (outside <= by) continue;
    by = outside;
    worst = arm::JointLimit{static_cast<std::size_t>(axis) + 1, below > above ? lowest : highest,
                            limits.lower, limits.upper};
  }
  return worst;
}

}  // namespace

std::optional<OutsideOnPath> first_outside(const arm::ArmModel& model, const Path& path) {
  JointValues allowance = beyond_limits(model, path.knot(0));
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    if (auto outside = outside_in(model, path.range(i), allowance)) {
      return OutsideOnPath{*outside, path.place(i)};
    }
    const JointValues beyond = beyond_limits(model, path.knot(i + 1));
    for (Eigen::Index axis = 0; axis < beyond.size(); ++axis) {
      if (beyond[axis] == 0) allowance[axis] = 0;
    }
  }
  const std::size_t last = path.intervals();
  const auto outside = arm::first_outside(model, path.knot(last));
  return outside ? std::optional(OutsideOnPath{*outside, path.place(last - 1)}) : std::nullopt;
}

JointValues Path::position(double s) const {
  const std::size_t i = interval_at(s);
  const double t = std::clamp((s - place(i)) / step(i), 0.0, 1.0);
  const double rest = 1 - t;
  return (1 + 2 * t) * rest * rest * knot(i) + t * rest * rest * step(i) * slopes_[i] +
         t * t * (3 - 2 * t) * knot(i + 1) - t * t * rest * step(i) * slopes_[i + 1];
}

}  // namespace robcl::motion
