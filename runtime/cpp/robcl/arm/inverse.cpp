#include "robcl/arm/inverse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "robcl/arm/numeric_inverse.hpp"
#include "robcl/arm/spherical_wrist.hpp"

namespace robcl::arm {
namespace {

constexpr double whole_turn = 2 * std::numbers::pi;
constexpr double rounding = 1e-9;  // rad by which rounding may put an angle outside a limit

/// Returns the angle by which `angle` is outside `limits`; infinity for NaN.
double outside(double angle, const JointLimits& limits) {
  if (std::isnan(angle)) return std::numeric_limits<double>::infinity();
  return std::max({0.0, limits.lower - angle - rounding, angle - limits.upper - rounding});
}

}  // namespace

std::unique_ptr<InverseKinematics> make_inverse(const ArmModel& model) {
  if (auto closed_form = SphericalWristInverse::for_arm(model)) return closed_form;
  return std::make_unique<NumericInverse>(model);
}

double travel_time(const ArmModel& model, const JointValues& from, const JointValues& to) {
  double seconds = 0;
  for (Eigen::Index i = 0; i < from.size(); ++i) {
    const double speed = model.limits()[static_cast<std::size_t>(i)].speed;
    seconds = std::max(seconds, std::abs(to[i] - from[i]) / speed);
  }
  return seconds;
}

double nearest_turn(double angle, double reference, const JointLimits& limits) {
  const double nearest = nearest_angle(angle, reference);
  double best = nearest;
  // Tries first the angle that is nearest to `reference` and differs from `angle` by whole turns.
  // Then tries the angles that are one and two turns away from this first angle. More turns are not
  // tried, because no known joint with limits turns so far.
  for (const int turns : {1, -1, 2, -2}) {
    if (outside(best, limits) == 0) break;
    const double copy = nearest + turns * whole_turn;
    if (outside(copy, limits) < outside(best, limits)) best = copy;
  }
  if (outside(best, limits) > 0) return best;
  return std::clamp(best, limits.lower, limits.upper);
}

std::optional<JointLimit> first_outside(const ArmModel& model, const JointValues& joints) {
  std::optional<JointLimit> worst;
  double by = 0;
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const JointLimits& limits = model.limits()[static_cast<std::size_t>(i)];
    if (outside(joints[i], limits) <= by) continue;
    by = outside(joints[i], limits);
    worst = JointLimit{static_cast<std::size_t>(i) + 1, joints[i], limits.lower, limits.upper};
  }
  return worst;
}

}  // namespace robcl::arm
