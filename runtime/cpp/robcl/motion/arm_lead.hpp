#pragma once

#include <cstdint>
#include <optional>

#include "robcl/arm/local_inverse.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/motion/joint_limiter.hpp"
#include "robcl/motion/tool_lead.hpp"

namespace robcl::motion {

/// Why a lead does not move towards its target.
struct Hold {
  std::uint32_t limit_axis = 0;  ///< this axis, from 1, would exceed its limits; 0: none
  bool out_of_reach = false;     ///< at the end of the arm's reach, or beside a singularity
};

/// A ToolLead that keeps to what an arm can do: its limits are so low that the joints can follow,
/// and it moves only where it can still brake to a place that the arm reaches within its limits and
/// away from singularities. Never allocates memory after it was made.
class ArmLead {
 public:
  /// The lead stands where the arm has the joint positions `joints`.
  ArmLead(const arm::ArmModel& model, const JointValues& joints, const Frame& flange_from_tool,
          const ToolLimits& limits);

  const Frame& pose() const { return lead_.pose; }
  const JointValues& joints() const { return at_.joints; }
  bool at_rest() const { return lead_.at_rest(); }
  bool stands_at(const Frame& target) const { return lead_.at_rest() && lead_.is_at(target); }

  /// Moves for one cycle of `cycle` seconds towards `target`, or brakes if it must not, or if there
  /// is no target. `followers`: the joints that follow the lead, which waits when they are behind.
  /// If it cannot brake within their limits, it is put where they stand soonest.
  /// `share`: the share of its speed limits that the lead may use, 0 to 1.
  Hold move(const std::optional<Frame>& target, double share, const JointLimiter& followers,
            double cycle);
  /// Stands where the arm has the joint positions `joints`.
  void put_at(const JointValues& joints);

 private:
  using Solution = arm::LocalInverse::Solution;
  /// How the lead moved in the last cycle.
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
  Solution at_;  // at the pose of lead_
  Change change_;
};

}  // namespace robcl::motion
