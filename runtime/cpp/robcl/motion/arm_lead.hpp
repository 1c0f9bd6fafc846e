#pragma once

#include <cstdint>
#include <optional>

#include "robcl/arm/local_inverse.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/motion/joint_limiter.hpp"
#include "robcl/motion/tool_lead.hpp"

namespace robcl::motion {

/// The reason for which a lead does not move towards its target.
struct Hold {
  std::uint32_t limit_axis = 0;  ///< this axis, from 1, would exceed its limits; 0: none
  bool out_of_reach = false;     ///< at the end of the arm's reach, or beside a singularity
};

/// A ToolLead whose limits are so low that the joints of the arm can follow the lead. The lead
/// moves only while it can still brake to a place that the arm reaches within its limits and away
/// from singularities. The constructor allocates all memory.
class ArmLead {
 public:
  /// The lead starts where the arm has the joint positions `joints`.
  ArmLead(const arm::ArmModel& model, const JointValues& joints, const Frame& flange_from_tool,
          const ToolLimits& limits);

  const Frame& pose() const { return lead_.pose; }
  const JointValues& joints() const { return at_.joints; }
  bool at_rest() const { return lead_.at_rest(); }
  bool stands_at(const Frame& target) const { return lead_.at_rest() && lead_.is_at(target); }

  /// Moves the lead for one cycle of `cycle` seconds towards `target`. The lead brakes if it must
  /// not move on, or if there is no target. `followers` are the joints that follow the lead; the
  /// lead waits while the joints are behind it. If the lead cannot brake within the limits of the
  /// joints, it jumps to the place where the joints come to rest soonest. `share` is the fraction
  /// of the speed limits that the lead may use, from 0 to 1.
  Hold move(const std::optional<Frame>& target, double share, const JointLimiter& followers,
            double cycle);
  /// Puts the lead at the place where the arm has the joint positions `joints`, and stops the lead
  /// there.
  void put_at(const JointValues& joints);

 private:
  using Solution = arm::LocalInverse::Solution;
  /// The motion of the lead in the last cycle.
  struct Change {
    JointValues speeds, accelerations;                   // rad/s, rad/s²
    arm::PoseStep acceleration = arm::PoseStep::Zero();  // of the tool, m/s² and rad/s²
  };

  std::optional<Hold> try_towards(const Frame& target, const ToolLimits& limits, double cycle);
  std::optional<Hold> why_not_stop(const ToolLead& lead, const Solution& at, const Frame& target,
                                   const ToolLimits& limits, double cycle) const;
  std::optional<Hold> why_not_stand(const std::optional<Solution>& there) const;
  void brake(const ToolLimits& limits, const JointLimiter& followers, double cycle);
  void accept(const ToolLead& lead, const Solution& at, double cycle);
  ToolLimits limits_at(const arm::DampedInverse& inverse, const ToolLead& lead,
                       const Frame& target) const;
  double bend_excess() const;

  const arm::ArmModel model_;
  const ToolLimits limits_;
  const arm::LocalInverse inverse_;

  ToolLead lead_;
  Solution at_;  // joint positions that put the tool at lead_.pose
  Change change_;
};

}  // namespace robcl::motion
