// What a straight move says if a joint would leave its travel on the way.
#include <gtest/gtest.h>

#include <string>

#include "arms.hpp"
#include "robcl/motion/planner.hpp"

namespace robcl::motion {
namespace {

using arm::Configuration;
using arm::JointLimit;

/// The tool is down in front of the arm, and joint 6 is 10 degrees from its limit of 270.
const JointValues nearly_turned = joints({0, -20, 110, 0, 90, 260});
const Configuration tool_down{arm::Shoulder::Righty, arm::Elbow::Above, arm::Wrist::Flip};

class StraightLines : public ::testing::Test {
 protected:
  /// Returns why the arm does not move from nearly_turned to where joint 6 would be at 280 degrees,
  /// on a line of `length` m.
  arm::Failure why_not(double length) {
    JointValues turned = nearly_turned;
    turned[5] = 280_deg;
    const Frame goal = translate(0, 0, -length) * forward_.base_from_flange(turned);
    EXPECT_TRUE(planner_.joints_to(nearly_turned, goal, Frame(), {})) << "the goal is possible";
    const auto plan = planner_.straight(nearly_turned, goal, Frame(), {});
    EXPECT_FALSE(plan);
    return plan ? arm::Failure() : plan.error();
  }

  const ToolLimits tool_limits_{};
  Planner planner_{rx90(), tool_limits_};
  arm::Kinematics forward_{rx90()};
};

TEST_F(StraightLines, AJointLimitOnTheWayIsToldWithItsPlaceAndTheConfiguration) {
  const arm::Failure why = why_not(0.1);
  const auto* limit = std::get_if<JointLimit>(&why);
  ASSERT_NE(limit, nullptr) << to_string(why);
  EXPECT_EQ(limit->axis, 6U);
  EXPECT_NEAR(limit->upper, 270_deg, 1e-9);
  EXPECT_GT(limit->value, limit->upper);
  EXPECT_LT(limit->value, limit->upper + 0.5_deg) << "the first place that is not possible";
  ASSERT_TRUE(limit->place);
  EXPECT_NEAR(limit->place->way, 50_mm, 1.1_mm);  // half of the line; the knots are 1 mm apart
  EXPECT_NEAR(limit->place->turn, 10_deg, 0.25_deg);
  EXPECT_EQ(limit->configuration, tool_down);
  EXPECT_EQ(to_string(why),
            to_string(*limit->place) +
                ": joint 6 would have to stand at 270.2 deg, but its range is -270.0 to 270.0 deg "
                "(configuration righty, above, flip)");
  EXPECT_NE(to_string(why).find(" mm along the line"), std::string::npos) << to_string(why);
}

TEST_F(StraightLines, AJointLimitInATurnInPlaceIsToldWithTheAngle) {
  const arm::Failure why = why_not(0);
  const auto* limit = std::get_if<JointLimit>(&why);
  ASSERT_NE(limit, nullptr) << to_string(why);
  ASSERT_TRUE(limit->place);
  EXPECT_NEAR(limit->place->way, 0, 1e-9);
  EXPECT_NEAR(limit->place->turn, 10_deg, 0.5_deg);
  EXPECT_NE(to_string(why).find(" deg into the turn: joint 6"), std::string::npos);
}

TEST_F(StraightLines, AJointLimitOfTheGoalHasNoPlace) {
  // In front of the arm, lefty would need joint 1 at 180 degrees.
  const JointValues from = joints({0, 60, 30, 0, 45, 0});
  const Configuration lefty{.shoulder = arm::Shoulder::Lefty};
  const auto move = planner_.joint_move_to(from, forward_.base_from_flange(from), {}, {}, lefty);
  ASSERT_FALSE(move);
  const auto* limit = std::get_if<JointLimit>(&move.error());
  ASSERT_NE(limit, nullptr) << to_string(move.error());
  EXPECT_EQ(limit->axis, 1U);
  EXPECT_FALSE(limit->place);
  EXPECT_EQ(limit->configuration.shoulder, arm::Shoulder::Lefty);

  const auto joint_goal = planner_.joint_move(from, joints({0, 0, 0, 0, -110, 0}), {});
  ASSERT_FALSE(joint_goal);
  EXPECT_EQ(std::get<JointLimit>(joint_goal.error()).configuration, Configuration{});
}

TEST(StraightLinesOfSevenJoints, NameNoConfiguration) {
  const arm::ArmModel model = seven_axes();
  Planner planner(model, {});
  const JointValues from = joints({0, 20, 0, -90, 0, 70, 170});
  const Frame goal = planner.base_from_tool(joints({0, 20, 0, -90, 0, 70, 180}), {});
  const auto move = planner.straight_move(from, goal, {}, {});
  ASSERT_FALSE(move);
  const auto* limit = std::get_if<JointLimit>(&move.error());
  ASSERT_NE(limit, nullptr) << to_string(move.error());
  EXPECT_EQ(limit->axis, 7U);
  ASSERT_TRUE(limit->place);
  EXPECT_NEAR(limit->place->turn, 5_deg, 0.5_deg);  // its limit is 175 degrees
  EXPECT_EQ(limit->configuration, Configuration{});
}

}  // namespace
}  // namespace robcl::motion
