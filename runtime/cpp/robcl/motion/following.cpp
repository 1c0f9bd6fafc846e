#include "robcl/motion/following.hpp"

#include <algorithm>
#include <cmath>

#include "robcl/arm/inverse.hpp"

namespace robcl::motion {
namespace {

// The shares of a joint's speed and acceleration that a change of the tool's speed may ask for, and
// the share of its acceleration that a bend of the joint's way at constant speed of the tool may.
constexpr double speed_share = 0.95, change_share = 0.6, bend_share = 0.35;
// The tool moves this much slower than its limits at most: at a singularity no speed is low enough
// for the joints, and JointLimiter limits them.
constexpr double slowest = 20;
// The tool does not move nearer to a singularity, as DampedInverse measures it: joints
// would move by more than 20 rad per m of the tool.
constexpr double near_singularity = 0.05;
constexpr double limit_rounding = 1e-9;  // m or rad

/// Returns the twist in the direction of `way` with the given speeds; a part of the way that is
/// zero stays so.
arm::PoseStep twist(const arm::PoseStep& way, double speed, double turn_speed) {
  arm::PoseStep result;
  result << way.head<3>().stableNormalized() * speed, way.tail<3>().stableNormalized() * turn_speed;
  return result;
}

arm::PoseStep twist_of(const ToolLead& lead) {
  arm::PoseStep result;
  result << lead.speed, lead.turn_speed;
  return result;
}

}  // namespace

Following::Following(const arm::ArmModel& model, const JointValues& start,
                     const Frame& flange_from_tool, CorrectionAxes axes, const FollowLimits& limits,
                     CorrectionSource& source)
    : model_(model),
      start_(start),
      flange_from_tool_(flange_from_tool),
      tool_from_flange_(flange_from_tool.inverse()),
      axes_(axes),
      limits_(limits),
      source_(source),
      forward_(model),
      inverse_(model),
      origin_(forward_.base_from_flange(start) * flange_from_tool),
      target_(origin_),
      lead_{origin_},
      lead_at_{start, forward_.place(start)},
      lead_change_{JointValues::Zero(start.size()), JointValues::Zero(start.size())},
      joints_(model.limits(), start) {}

JointValues Following::advance(double seconds) {
  if (!stopping_) take_corrections();
  state_.limit_axis = 0;
  state_.out_of_reach = false;
  const bool arrived = lead_.at_rest() && (stopping_ || lead_.is_at(target_));
  if (!arrived) {
    ToolLimits limits = limits_at(lead_at_.place, lead_);
    if (const double excess = bend_excess(); excess > 1) {
      limits.speed = std::min(limits.speed, lead_.speed.norm() / excess);
      limits.turn_speed = std::min(limits.turn_speed, lead_.turn_speed.norm() / excess);
    }
    // A lead that the joints are behind waits for them.
    if (!joints_.near_target(seconds)) limits.speed = limits.turn_speed = 0;
    if (stopping_ || !try_towards_target(limits, seconds)) brake(limits, seconds);
  }
  joints_.follow(lead_at_.joints, seconds);
  report();
  return joints_.joints();
}

void Following::take_corrections() {
  while (const auto correction = source_.next()) apply(*correction);
  if (!source_.expired()) return;
  expired_ = true;
  stopping_ = true;
}

void Following::apply(const Frame& correction) {
  const Frame target = axes_ == CorrectionAxes::Tool
                           ? target_ * correction
                           : Frame(target_.position() + correction.position(),
                                   correction.orientation() * target_.orientation());
  if (distance(origin_, target) > limits_.distance + limit_rounding ||
      angle(origin_, target) > limits_.angle + limit_rounding) {
    ++state_.dropped;
    return;
  }
  target_ = target;
  ++state_.applied;
}

/// Returns the limits of the tool at `place`, so low that the joints can follow: with the greatest
/// speed and acceleration in the direction of the target, and in the direction of the lead's
/// motion, no joint exceeds its own.
ToolLimits Following::limits_at(const arm::Kinematics::Place& place, const ToolLead& lead) const {
  const arm::DampedInverse inverse(tool_jacobian(place));
  double slower = 1, softer = 1;
  for (const arm::PoseStep& way : {arm::step_between(lead.pose, target_), twist_of(lead)}) {
    const JointValues speeds =
        inverse.joint_speeds(twist(way, limits_.tool.speed, limits_.tool.turn_speed));
    const JointValues accelerations =
        inverse.joint_speeds(twist(way, limits_.tool.acceleration, limits_.tool.turn_acceleration));
    for (Eigen::Index i = 0; i < speeds.size(); ++i) {
      const arm::JointLimits& limits = model_.limits()[static_cast<std::size_t>(i)];
      slower = std::max(slower, std::abs(speeds[i]) / (speed_share * limits.speed));
      softer = std::max(softer, std::abs(accelerations[i]) / (change_share * limits.acceleration));
    }
  }
  slower = std::min(slower, slowest);
  softer = std::min(softer, slowest);
  return {.speed = limits_.tool.speed / slower,
          .acceleration = limits_.tool.acceleration / softer,
          .turn_speed = limits_.tool.turn_speed / slower,
          .turn_acceleration = limits_.tool.turn_acceleration / softer};
}

arm::Jacobian Following::tool_jacobian(const arm::Kinematics::Place& place) const {
  arm::Jacobian jacobian = place.jacobian;
  const Eigen::Vector3d lever = place.base_from_flange.orientation() * flange_from_tool_.position();
  for (Eigen::Index i = 0; i < jacobian.cols(); ++i) {
    jacobian.col(i).head<3>() += jacobian.col(i).tail<3>().cross(lever);
  }
  return jacobian;
}

/// Returns the factor by which the lead is too fast for the bends of the joints' way: their
/// accelerations at a constant speed of the tool, which rise with the square of that speed.
double Following::bend_excess() const {
  const arm::DampedInverse inverse(tool_jacobian(lead_at_.place));
  const JointValues bend =
      lead_change_.accelerations - inverse.joint_speeds(lead_change_.acceleration);
  double excess = 0;
  for (Eigen::Index i = 0; i < bend.size(); ++i) {
    const double allowed = model_.limits()[static_cast<std::size_t>(i)].acceleration * bend_share;
    excess = std::max(excess, std::abs(bend[i]) / allowed);
  }
  return std::sqrt(excess);
}

bool Following::try_towards_target(const ToolLimits& limits, double cycle) {
  const ToolLead next = lead_.towards(target_, limits, cycle);
  const auto reached = joints_at(next.pose, lead_at_.joints);
  if (!reached || !can_stop(next, reached->joints, limits, cycle)) {
    state_.out_of_reach = state_.limit_axis == 0;
    return false;
  }
  move_lead(next, *reached, cycle);
  return true;
}

/// Whether the lead can brake so that it stands where the arm may stand. The limits of the tool may
/// be lower there than here: then its way is longer.
bool Following::can_stop(const ToolLead& lead, const JointValues& joints, const ToolLimits& limits,
                         double cycle) {
  const auto soonest = joints_at(lead.stop(limits, cycle), joints);
  if (!soonest || !may_stand_at(*soonest)) return false;
  const ToolLimits there = limits_at(soonest->place, lead);
  if (there.acceleration >= limits.acceleration) return true;
  const auto latest = joints_at(lead.stop(there, cycle), joints);
  return latest && may_stand_at(*latest);
}

/// Whether the joints are within their limits and away from singularities.
bool Following::may_stand_at(const arm::LocalInverse::Solution& there) {
  const auto outside = arm::first_outside(model_, there.joints);
  if (outside) state_.limit_axis = static_cast<std::uint32_t>(outside->axis);
  if (outside) return false;
  const double distance = arm::DampedInverse(there.place.jacobian).singularity_distance();
  return distance >= near_singularity ||
         distance >= arm::DampedInverse(lead_at_.place.jacobian).singularity_distance();
}

void Following::brake(const ToolLimits& limits, double cycle) {
  const ToolLead next = lead_.braking(limits, cycle);
  const auto reached = joints_at(next.pose, lead_at_.joints);
  // In a bend the joints may need more way to brake than the tool.
  if (!reached || arm::first_outside(model_, reached->joints)) {
    return put_lead_at(joints_.stop(cycle));
  }
  move_lead(next, *reached, cycle);
}

void Following::move_lead(const ToolLead& lead, const arm::LocalInverse::Solution& at,
                          double cycle) {
  const JointValues speeds = (at.joints - lead_at_.joints) / cycle;
  lead_change_.accelerations = (speeds - lead_change_.speeds) / cycle;
  lead_change_.speeds = speeds;
  lead_change_.acceleration = (twist_of(lead) - twist_of(lead_)) / cycle;
  lead_ = lead;
  lead_at_ = at;
}

void Following::rest() {
  joints_.rest();
  put_lead_at(joints_.joints());
}

/// Lets the lead stand where the arm has the joint positions `joints`.
void Following::put_lead_at(const JointValues& joints) {
  lead_at_ = {joints, forward_.place(joints)};
  lead_change_ = {JointValues::Zero(joints.size()), JointValues::Zero(joints.size())};
  lead_ = ToolLead{lead_at_.place.base_from_flange * flange_from_tool_};
}

void Following::report() {
  const arm::PoseStep left = arm::step_between(lead_.pose, target_);
  state_.distance_left = left.head<3>().norm();
  state_.angle_left = left.tail<3>().norm();
  source_.report(state_);
}

}  // namespace robcl::motion
