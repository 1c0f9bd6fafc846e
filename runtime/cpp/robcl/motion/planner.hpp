// Makes a checked plan from the position of an arm and the goal of its tool.
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

/// Plans moves of one arm, from rest to rest. Allocates, so the control loop must not call it. Used
/// by one thread at a time.
class Planner {
 public:
  Planner(const arm::ArmModel& model, const ToolLimits& limits);

  /// Plans a straight line in joint space: all joints start and arrive together. Fails with
  /// JointLimit. @pre of all plans: the arm is at rest at `from`, and problem_of(pace) is empty.
  tl::expected<Plan, arm::Failure> joints(const JointValues& from, const JointValues& to,
                                          const Pace& pace, const Frame& flange_from_tool = {});

  /// Plans a straight line in joint space that puts the tool at `base_from_goal`, in a
  /// configuration that `wanted` admits. Of several possible joint positions, chooses those that
  /// the arm reaches soonest. Fails with OutOfReach or JointLimit.
  tl::expected<Plan, arm::Failure> joints_to(const JointValues& from, const Frame& base_from_goal,
                                             const Frame& flange_from_tool, const Pace& pace,
                                             const arm::Configuration& wanted = {});

  /// Plans a straight line of the tool to `base_from_goal`, while its orientation turns about one
  /// axis. The arm keeps its present configuration. Fails with OutOfReach, JointLimit or Singular.
  tl::expected<Plan, arm::Failure> straight(const JointValues& from, const Frame& base_from_goal,
                                            const Frame& flange_from_tool, const Pace& pace);

  Frame base_from_tool(const JointValues& joints, const Frame& flange_from_tool);
  arm::Configuration configuration(const JointValues& joints) {
    return inverse_->configuration(joints);
  }

 private:
  tl::expected<Path, arm::Failure> path_of_line(const JointValues& from, const Line& line,
                                                const Frame& tool_from_flange);
  tl::expected<std::vector<JointValues>, arm::Failure> knots_of_line(const JointValues& from,
                                                                     const Line& line,
                                                                     const Frame& tool_from_flange,
                                                                     std::size_t intervals);
  std::optional<arm::OutOfReach> absurd(const Frame& base_from_goal) const;

  arm::ArmModel model_;
  ToolLimits limits_;
  arm::Kinematics forward_;
  std::unique_ptr<arm::InverseKinematics> inverse_;
};

}  // namespace robcl::motion
