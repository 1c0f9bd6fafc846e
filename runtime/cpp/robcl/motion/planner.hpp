// Makes checked plans for the moves of an arm.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "gecos/base/result.hpp"
#include "robcl/arm/failure.hpp"
#include "robcl/arm/inverse.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/motion/line.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/plan.hpp"

namespace robcl::motion {

/// Plans the moves of one arm. Each move starts and ends at rest. The planner allocates memory, so
/// that the control loop must not use it. Only one thread at a time may use it.
class Planner {
 public:
  Planner(const arm::ArmModel& model, const ToolLimits& limits);

  /// Plans a move of all joints to the positions `to`; the joints start and arrive together. May
  /// fail with JointLimit. @pre for this and the following functions: the arm is at rest at the
  /// joint positions `from`, and problem_of(pace) is empty.
  tl::expected<Plan, arm::Failure> joints(const JointValues& from, const JointValues& to,
                                          const Pace& pace, const Frame& flange_from_tool = {});

  /// Plans a move of all joints that puts the tool at the frame `base_from_goal`, in a
  /// configuration that `wanted` admits; without `wanted`, in the present one. If several joint
  /// positions are possible, chooses those that the arm reaches soonest. May fail with OutOfReach
  /// or JointLimit. If only another configuration than the present one can reach the goal, the
  /// failure names it.
  tl::expected<Plan, arm::Failure> joints_to(
      const JointValues& from, const Frame& base_from_goal, const Frame& flange_from_tool,
      const Pace& pace, const std::optional<arm::Configuration>& wanted = std::nullopt);

  /// Plans a move of the tool along a straight line to the frame `base_from_goal`. During the move,
  /// the tool's orientation turns about one axis, and the arm keeps its present configuration. May
  /// fail with OutOfReach, JointLimit or Singular.
  tl::expected<Plan, arm::Failure> straight(const JointValues& from, const Frame& base_from_goal,
                                            const Frame& flange_from_tool, const Pace& pace);

  Frame base_from_tool(const JointValues& joints, const Frame& flange_from_tool);
  arm::Configuration configuration(const JointValues& joints) {
    return inverse_->configuration(joints);
  }

 private:
  tl::expected<Path, arm::Failure> path_of_line(const JointValues& from, const Line& line,
                                                const Frame& tool_from_flange);
  /// `coarse`: the knots for half as many intervals, whose positions are used again; may be empty.
  tl::expected<std::vector<JointValues>, arm::Failure> knots_of_line(
      const JointValues& from, const Line& line, const Frame& tool_from_flange,
      std::size_t intervals, const std::vector<JointValues>& coarse);
  std::optional<arm::OutOfReach> absurd(const Frame& base_from_goal) const;

  arm::ArmModel model_;
  ToolLimits limits_;
  arm::Kinematics forward_;
  std::unique_ptr<arm::InverseKinematics> inverse_;
};

}  // namespace robcl::motion
