#include "robcl/motion/arm_lead.hpp"

#include <algorithm>
#include <cmath>

#include "robcl/arm/inverse.hpp"

namespace robcl::motion {
namespace {

// The lead chooses the speed of the tool so that no joint exceeds these shares of its own limits:
// `speed_share` of the limit of speed; `change_share` of the limit of acceleration, while the tool
// changes its speed; `bend_share` of the limit of acceleration, in a bend that the tool passes at
// constant speed.
constexpr double speed_share = 0.95, change_share = 0.6, bend_share = 0.35;
// The greatest factor by which the lead slows the tool. At a singularity, no speed of the tool is
// low enough for the joints. There, JointLimiter limits the speeds of the joints.
constexpr double slowest = 20;
// The least distance to a singularity, as DampedInverse measures it. The tool does not move nearer
// to the singularity, because a joint would then turn by more than 20 rad while the tool moves 1 m.
constexpr double near_singularity = 0.05;
// The accuracy, in m and rad, of the place at which the lead would stand if it braked now. This low
// accuracy is enough, because JointLimiter keeps the limits of the joints in any case.
constexpr double foresight = 1e-6;

/// Returns the twist in the direction of `way` with the given speeds. If the displacement or the
/// rotation of `way` is zero, it remains zero.
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

ArmLead::ArmLead(const arm::ArmModel& model, const JointValues& joints,
                 const Frame& flange_from_tool, const ToolLimits& limits)
    : model_(model), limits_(limits), inverse_(model, flange_from_tool), at_(inverse_.at(joints)) {
  put_at(joints);
}

void ArmLead::put_at(const JointValues& joints) {
  at_ = inverse_.at(joints);
  change_ = {JointValues::Zero(joints.size()), JointValues::Zero(joints.size())};
  lead_ = ToolLead{at_.base_from_tool};
}

Hold ArmLead::move(const std::optional<Frame>& target, double share, const JointLimiter& followers,
                   double cycle) {
  if (lead_.at_rest() && (!target || lead_.is_at(*target))) return {};
  ToolLimits limits = limits_at(at_.inverse, lead_, target.value_or(lead_.pose));
  if (const double excess = bend_excess(); excess > 1) {
    limits.speed = std::min(limits.speed, lead_.speed.norm() / excess);
    limits.turn_speed = std::min(limits.turn_speed, lead_.turn_speed.norm() / excess);
  }
  limits.speed *= share;
  limits.turn_speed *= share;
  if (!followers.near_target(cycle)) limits.speed = limits.turn_speed = 0;
  std::optional<Hold> hold;
  if (target) hold = try_towards(*target, limits, cycle);
  if (!target || hold) brake(limits, followers, cycle);
  return hold.value_or(Hold{});
}

/// Moves the lead for one cycle towards `target`, if the lead may move on. Returns nullopt if it
/// has moved, otherwise the reason why not.
std::optional<Hold> ArmLead::try_towards(const Frame& target, const ToolLimits& limits,
                                         double cycle) {
  const ToolLead next = lead_.towards(target, limits, cycle);
  const auto there = inverse_.solve(next.pose, at_);
  if (!there) return Hold{.out_of_reach = true};
  if (const auto hold = why_not_stop(next, *there, target, limits, cycle)) return hold;
  accept(next, *there, cycle);
  return std::nullopt;
}

/// Returns why the lead could not brake from the state `lead` to a place where the arm may stand;
/// nullopt if it could. If the limits of the tool are lower at that place, the lead needs more
/// distance to brake. This function then also checks the place that the lead reaches with this
/// longer distance.
std::optional<Hold> ArmLead::why_not_stop(const ToolLead& lead, const Solution& at,
                                          const Frame& target, const ToolLimits& limits,
                                          double cycle) const {
  const auto soonest = inverse_.solve(lead.stop(limits, cycle), at, foresight);
  if (const auto hold = why_not_stand(soonest)) return hold;
  const ToolLimits there = limits_at(soonest->inverse, lead, target);
  if (there.acceleration >= limits.acceleration) return std::nullopt;
  return why_not_stand(inverse_.solve(lead.stop(there, cycle), at, foresight));
}

std::optional<Hold> ArmLead::why_not_stand(const std::optional<Solution>& there) const {
  if (!there) return Hold{.out_of_reach = true};
  if (const auto outside = arm::first_outside(model_, there->joints)) {
    return Hold{.limit_axis = static_cast<std::uint32_t>(outside->axis)};
  }
  const double distance = there->inverse.singularity_distance();
  // A lead that is already nearer to a singularity than the limit may move away from the
  // singularity.
  if (distance >= near_singularity || distance >= at_.inverse.singularity_distance()) {
    return std::nullopt;
  }
  return Hold{.out_of_reach = true};
}

void ArmLead::brake(const ToolLimits& limits, const JointLimiter& followers, double cycle) {
  const ToolLead next = lead_.braking(limits, cycle);
  const auto there = inverse_.solve(next.pose, at_);
  // In a bend, the joints may need a longer distance to brake than the tool. The lead then jumps to
  // the place where the joints come to rest soonest.
  if (!there || arm::first_outside(model_, there->joints)) return put_at(followers.stop(cycle));
  accept(next, *there, cycle);
}

void ArmLead::accept(const ToolLead& lead, const Solution& at, double cycle) {
  const JointValues speeds = (at.joints - at_.joints) / cycle;
  change_.accelerations = (speeds - change_.speeds) / cycle;
  change_.speeds = speeds;
  change_.acceleration = (twist_of(lead) - twist_of(lead_)) / cycle;
  lead_ = lead;
  at_ = at;
}

/// Returns the limits of the tool at the joint positions of `inverse`. These limits are so low that
/// no joint exceeds its share (see `speed_share`) when the tool moves with the greatest speed and
/// acceleration towards the target, or in the direction of the lead's motion.
ToolLimits ArmLead::limits_at(const arm::DampedInverse& inverse, const ToolLead& lead,
                              const Frame& target) const {
  double slower = 1, softer = 1;
  for (const arm::PoseStep& way : {arm::step_between(lead.pose, target), twist_of(lead)}) {
    const JointValues speeds = inverse.joint_speeds(twist(way, limits_.speed, limits_.turn_speed));
    const JointValues accelerations =
        inverse.joint_speeds(twist(way, limits_.acceleration, limits_.turn_acceleration));
    for (Eigen::Index i = 0; i < speeds.size(); ++i) {
      const arm::JointLimits& limits = model_.limits()[static_cast<std::size_t>(i)];
      slower = std::max(slower, std::abs(speeds[i]) / (speed_share * limits.speed));
      softer = std::max(softer, std::abs(accelerations[i]) / (change_share * limits.acceleration));
    }
  }
  slower = std::min(slower, slowest);
  softer = std::min(softer, slowest);
  return {.speed = limits_.speed / slower,
          .acceleration = limits_.acceleration / softer,
          .turn_speed = limits_.turn_speed / slower,
          .turn_acceleration = limits_.turn_acceleration / softer};
}

/// Returns the factor by which the speed of the lead is too high for the bends in the paths of the
/// joints. At a constant speed of the tool, the joints accelerate in a bend, and this acceleration
/// rises with the square of the speed.
double ArmLead::bend_excess() const {
  const JointValues bend = change_.accelerations - at_.inverse.joint_speeds(change_.acceleration);
  double excess = 0;
  for (Eigen::Index i = 0; i < bend.size(); ++i) {
    const double allowed = model_.limits()[static_cast<std::size_t>(i)].acceleration * bend_share;
    excess = std::max(excess, std::abs(bend[i]) / allowed);
  }
  return std::sqrt(excess);
}

}  // namespace robcl::motion
