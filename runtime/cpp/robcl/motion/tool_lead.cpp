#include "robcl/motion/tool_lead.hpp"

#include <algorithm>

#include "robcl/arm/local_inverse.hpp"
#include "robcl/motion/braking.hpp"

namespace robcl::motion {
namespace {

using Eigen::Vector3d;

constexpr double arrived = 1e-12;  // m or rad; less is rounding

Frame after(const Frame& pose, const Vector3d& way, const Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Frame(pose.position() + way, pose.orientation());
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, turn / angle));
  return Frame(pose.position() + way, turned * pose.orientation());
}

/// Returns the speed after the next cycle for a motion that has the speed `now`: the speed nearest
/// to `wanted` that the motion can reach with at most the acceleration `acceleration`.
Vector3d nearest_allowed(const Vector3d& now, const Vector3d& wanted, double acceleration,
                         double cycle) {
  const Vector3d change = wanted - now;
  const double allowed = acceleration * cycle, size = change.norm();
  return size <= allowed ? wanted : Vector3d(now + change * (allowed / size));
}

Vector3d speed_towards(const Vector3d& away, double fastest, double acceleration, double cycle) {
  const double distance = away.norm();
  if (distance < arrived) return Vector3d::Zero();
  return away * (std::min(fastest, stopping_speed(distance, acceleration, cycle)) / distance);
}

Vector3d way_to_stop(const Vector3d& speed, double acceleration, double cycle) {
  const double size = speed.norm();
  if (size == 0) return Vector3d::Zero();
  return speed * (stopping_distance(size, acceleration, cycle) / size);
}

}  // namespace

ToolLead ToolLead::moved(const Vector3d& new_speed, const Vector3d& new_turn_speed,
                         double cycle) const {
  return {after(pose, new_speed * cycle, new_turn_speed * cycle), new_speed, new_turn_speed};
}

ToolLead ToolLead::towards(const Frame& target, const ToolLimits& limits, double cycle) const {
  const arm::PoseStep away = arm::step_between(pose, target);
  const Vector3d wanted = speed_towards(away.head<3>(), limits.speed, limits.acceleration, cycle);
  const Vector3d wanted_turn =
      speed_towards(away.tail<3>(), limits.turn_speed, limits.turn_acceleration, cycle);
  return moved(nearest_allowed(speed, wanted, limits.acceleration, cycle),
               nearest_allowed(turn_speed, wanted_turn, limits.turn_acceleration, cycle), cycle);
}

ToolLead ToolLead::braking(const ToolLimits& limits, double cycle) const {
  return moved(nearest_allowed(speed, Vector3d::Zero(), limits.acceleration, cycle),
               nearest_allowed(turn_speed, Vector3d::Zero(), limits.turn_acceleration, cycle),
               cycle);
}

bool ToolLead::is_at(const Frame& target) const {
  const arm::PoseStep away = arm::step_between(pose, target);
  return away.head<3>().norm() < arrived && away.tail<3>().norm() < arrived;
}

Frame ToolLead::stop(const ToolLimits& limits, double cycle) const {
  return after(pose, way_to_stop(speed, limits.acceleration, cycle),
               way_to_stop(turn_speed, limits.turn_acceleration, cycle));
}

}  // namespace robcl::motion
