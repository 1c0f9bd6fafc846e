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
#include "robcl/motion/move.hpp"
#include "robcl/motion/plan.hpp"

namespace robcl::motion {

/// Plans the moves of one arm. The planner allocates memory, so the control loop must not use the
/// planner. Only one thread at a time may use it.
class Planner {
 public:
  Planner(const arm::ArmModel& model, const ToolLimits& limits, const Smoothing& smoothing = {});

  /// Makes a move of all joints to the positions `to`; the joints start and arrive together. May
  /// fail with JointLimit. @pre for this and the following functions: the arm starts at the joint
  /// positions `from`, and problem_of(pace) is empty.
  tl::expected<Move, arm::Failure> joint_move(const JointValues& from, const JointValues& to,
                                              const Pace& pace, const Frame& flange_from_tool = {});

  /// Makes a move of all joints that puts the tool at the frame `base_from_goal`, in a
  /// configuration that `wanted` admits. Without `wanted`, the arm keeps its present configuration.
  /// If several joint positions are possible, chooses the ones that the arm reaches soonest. May
  /// fail with OutOfReach or JointLimit. If `wanted` is missing, and the arm can reach the goal
  /// only in another configuration than its present one, the failure names such a configuration.
  tl::expected<Move, arm::Failure> joint_move_to(
      const JointValues& from, const Frame& base_from_goal, const Frame& flange_from_tool,
      const Pace& pace, const std::optional<arm::Configuration>& wanted = std::nullopt);

  /// Makes a move of the tool along a straight line to the frame `base_from_goal`. During the move,
  /// the tool's orientation turns about one axis, and the arm keeps its present configuration. May
  /// fail with OutOfReach, JointLimit or Singular.
  tl::expected<Move, arm::Failure> straight_move(const JointValues& from,
                                                 const Frame& base_from_goal,
                                                 const Frame& flange_from_tool, const Pace& pace);

  /// Plans the fastest motion of `move` that starts and ends at rest. This function and the
  /// functions that call it throw std::runtime_error if the limits make the arm stop before the
  /// goal.
  Plan plan(const Move& move) const;

  /// Functions that make a move and its plan.
  tl::expected<Plan, arm::Failure> joints(const JointValues& from, const JointValues& to,
                                          const Pace& pace, const Frame& flange_from_tool = {}) {
    return plan_of(joint_move(from, to, pace, flange_from_tool));
  }
  tl::expected<Plan, arm::Failure> joints_to(
      const JointValues& from, const Frame& base_from_goal, const Frame& flange_from_tool,
      const Pace& pace, const std::optional<arm::Configuration>& wanted = std::nullopt) {
    return plan_of(joint_move_to(from, base_from_goal, flange_from_tool, pace, wanted));
  }
  tl::expected<Plan, arm::Failure> straight(const JointValues& from, const Frame& base_from_goal,
                                            const Frame& flange_from_tool, const Pace& pace) {
    return plan_of(straight_move(from, base_from_goal, flange_from_tool, pace));
  }

  Frame base_from_tool(const JointValues& joints, const Frame& flange_from_tool);
  arm::Configuration configuration(const JointValues& joints) {
    return inverse_->configuration(joints);
  }

  const arm::Kinematics& forward() const { return forward_; }
  const arm::ArmModel& model() const { return model_; }
  const ToolLimits& tool_limits() const { return limits_; }
  const Smoothing& smoothing() const { return smoothing_; }
  arm::InverseKinematics& inverse() { return *inverse_; }

 private:
  tl::expected<Plan, arm::Failure> plan_of(const tl::expected<Move, arm::Failure>& move) const;
  std::vector<double> caps_of_tool(const Path& path, const Pace& pace,
                                   const Frame& flange_from_tool);
  std::optional<arm::OutOfReach> absurd(const Frame& base_from_goal) const;

  arm::ArmModel model_;
  ToolLimits limits_;
  Smoothing smoothing_;
  arm::Kinematics forward_;
  std::unique_ptr<arm::InverseKinematics> inverse_;
};

}  // namespace robcl::motion
