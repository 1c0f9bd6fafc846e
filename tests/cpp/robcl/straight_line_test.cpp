// What a straight move says if a joint would leave its travel on the way, and how fast it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "arms.hpp"
#include "robcl/motion/move_chain.hpp"
#include "robcl/motion/planner.hpp"
#include "robcl/motion/playback.hpp"
#include "set_points.hpp"

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

/// One count of an encoder, in rad: an arm at the limit of a joint may stand this far beyond it
/// after a fault of its drives.
constexpr double count = 2.4e-5;

/// Moves on a line that lets the joint `axis` (from 0) return from beyond its limit, where the arm
/// stands at `from`, by `angle`.
void expect_return(const arm::ArmModel& model, const JointValues& from, Eigen::Index axis,
                   double angle) {
  SCOPED_TRACE("joint " + std::to_string(axis + 1) + " by " + std::to_string(angle) + " rad");
  Planner planner(model, {});
  const arm::JointLimits& limits = model.limits()[static_cast<std::size_t>(axis)];
  const double side = from[axis] > 0 ? 1 : -1;
  JointValues to = from;
  to[axis] -= side * angle;
  const auto move = planner.straight_move(from, planner.base_from_tool(to, {}), {}, {});
  ASSERT_TRUE(move) << to_string(move.error());
  EXPECT_GE(move->goal()[axis], limits.lower);
  EXPECT_LE(move->goal()[axis], limits.upper);
  Playback playback(planner.plan(*move));
  while (!playback.standing()) {
    ASSERT_LE(side * playback.advance(0.004)[axis], side * from[axis] + 1e-9) << "further out";
  }
}

TEST(StraightLinesFromBeyondALimit, ReturnTheJoint) {
  for (const double angle : {10_deg, 3e-5, 1e-4, 1e-3}) {
    expect_return(rx90(), joints({-160, -20, 110, 0, 90, 0}) - count * JointValues::Unit(6, 0), 0,
                  angle);
    expect_return(rx90(), joints({0, -20, 110, 0, 120, 0}) + count * JointValues::Unit(6, 4), 4,
                  angle);
    expect_return(rx90(), joints({0, -20, 110, 0, 90, 270}) + count * JointValues::Unit(6, 5), 5,
                  angle);
    expect_return(seven_axes(),
                  joints({0, 20, 0, -90, 0, 70, 175}) + count * JointValues::Unit(7, 6), 6, angle);
  }
}

TEST(StraightLinesFromBeyondALimit, LeaveNoLimitAgainWhereverTheyLead) {
  for (const arm::ArmModel& model : {rx90(), puma560(), seven_axes()}) {
    Planner planner(model, {});
    RandomJoints random(model, 41);
    int made = 0;
    for (int i = 0; i < 2000 && made < 40; ++i) {
      JointValues from = random();
      const Eigen::Index axis = i % model.axes();
      const arm::JointLimits& limits = model.limits()[static_cast<std::size_t>(axis)];
      from[axis] = i % 2 == 0 ? limits.upper + count : limits.lower - count;
      const JointValues to = from + 0.3 * (random() - from);
      const auto move = planner.straight_move(from, planner.base_from_tool(to, {}), {}, {});
      if (!move) continue;
      ++made;
      bool returned = false;
      Playback playback(planner.plan(*move));
      while (!playback.standing()) {
        JointValues at = playback.advance(0.004);
        returned |= limits.lower <= at[axis] && at[axis] <= limits.upper;
        if (!returned) at[axis] -= from[axis] > 0 ? count : -count;
        ASSERT_FALSE(arm::first_outside(model, at)) << "line " << i;
      }
      ASSERT_TRUE(returned) << "line " << i;
    }
    EXPECT_EQ(made, 40);
  }
}

TEST(StraightLinesFromBeyondALimit, LeadNoFurtherOut) {
  Planner planner(rx90(), {});
  JointValues from = joints({0, -20, 110, 0, 90, 270}), further = from;
  from[5] += count;
  further[5] += 10_deg;
  const auto move = planner.straight_move(from, planner.base_from_tool(further, {}), {}, {});
  ASSERT_FALSE(move);
  const auto* limit = std::get_if<JointLimit>(&move.error());
  ASSERT_NE(limit, nullptr) << to_string(move.error());
  EXPECT_EQ(limit->axis, 6U);
  EXPECT_EQ(limit->upper, planner.model().limits()[5].upper);
  EXPECT_GT(limit->value, from[5]);
  ASSERT_TRUE(limit->place);
  EXPECT_LT(limit->place->turn, 0.25_deg);
}

TEST(StraightLinesFromBeyondALimit, DoNotEndBeyondIt) {
  Planner planner(rx90(), {});
  JointValues from = joints({0, -20, 110, 0, 120, 0});
  from[4] += count;
  JointValues nearer = from;
  nearer[4] -= count / 2;
  for (const Frame& goal :
       {planner.base_from_tool(nearer, {}), rotate_z(5_deg) * planner.base_from_tool(from, {})}) {
    const auto move = planner.straight_move(from, goal, {}, {});
    ASSERT_FALSE(move);
    EXPECT_NE(std::get_if<JointLimit>(&move.error()), nullptr) << to_string(move.error());
  }
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

/// On this line the joints turn so fast that the knots at the usual distance would let the tool
/// leave the line by .07 mm between two of them.
TEST(StraightLinesOfSevenJoints, KeepToTheLineWhereTheJointsTurnFast) {
  const arm::ArmModel model = seven_axes();
  Planner planner(model, {});
  JointValues from(7), to(7);
  from << 2.6250, 0.0668, -2.7770, 0.0047, 1.3621, -1.7994, -2.1295;
  to << 1.4898, -0.7742, -1.7475, 0.6337, 2.5123, -0.4109, -2.8639;
  const Frame start = planner.base_from_tool(from, {}), goal = planner.base_from_tool(to, {});
  const auto move = planner.straight_move(from, goal, {}, {});
  ASSERT_TRUE(move) << to_string(move.error());
  std::vector<Frame> tools;
  const double step = move->duration() / 50'000;
  for (double s = 0; s < move->duration(); s += step) {
    tools.push_back(planner.base_from_tool(move->path.position(s), {}));
  }
  expect_on_line(tools, start.position(), goal.position());

  // A chain leaves out knots that are close together, but none that the line needs.
  EXPECT_LT(move->most_turned, planner.joint_move(from, to, {})->most_turned);
}

/// Lines of the RX90 whose callers give the accelerations of the tool.
class AcceleratedLines : public StraightLines {
 protected:
  static constexpr double cycle = 0.004;                       // s
  const JointValues ready_ = joints({0, -20, 110, 0, 90, 0});  // tool down in front
  const Frame start_ = forward_.base_from_flange(ready_);

  /// Returns the poses of the flange in all cycles of a motion.
  std::vector<Frame> poses(const Plan& plan) {
    Playback playback(plan);
    std::vector<Frame> all(2, forward_.base_from_flange(plan.start()));
    while (!playback.standing()) {
      all.push_back(forward_.base_from_flange(playback.advance(cycle)));
    }
    all.push_back(all.back());
    return all;
  }

  /// The greatest accelerations along the line and in turning, in m/s² and rad/s².
  struct Fastest {
    double way = 0, turn = 0;
  };
  Fastest fastest(const Plan& plan) {
    const std::vector<Frame> all = poses(plan);
    const Frame &from = all.front(), &to = all.back();
    Fastest most;
    for (std::size_t k = 1; k + 1 < all.size(); ++k) {
      const auto second = [&](auto measure) {
        return std::abs(measure(from, all[k + 1]) - 2 * measure(from, all[k]) +
                        measure(from, all[k - 1])) /
               (cycle * cycle);
      };
      const double way = second([](const Frame& a, const Frame& b) { return distance(a, b); });
      most.way = std::max(most.way, way);
      if (angle(from, to) > 3) continue;  // rad: beyond half a turn, an angle would fall again
      most.turn =
          std::max(most.turn, second([](const Frame& a, const Frame& b) { return angle(a, b); }));
    }
    return most;
  }
};

TEST_F(AcceleratedLines, ATrapezoidHasTheAccelerationAndTheTimeThatWereAskedFor) {
  const Pace pace{.tool_speed = 0.2, .tool_acceleration = 0.5};
  const auto plan = planner_.straight(ready_, start_ * translate(0, 0, 0.2), {}, pace);
  ASSERT_TRUE(plan) << to_string(plan.error());
  EXPECT_NEAR(plan->duration(), 0.2 / 0.2 + 0.2 / 0.5, 2e-3);
  const double most = fastest(*plan).way;
  EXPECT_LE(most, 0.5 * 1.001);
  EXPECT_GE(most, 0.5 * 0.99);
}

TEST_F(AcceleratedLines, ATurnInPlaceHasTheAccelerationAndTheTimeThatWereAskedFor) {
  const Pace pace{.turn_speed = 0.5, .turn_acceleration = 1};
  const Frame goal = start_ * Frame::from_euler_zyz(0, 0, 0, 0, 0, 0.6);
  const auto plan = planner_.straight(ready_, goal, {}, pace);
  ASSERT_TRUE(plan) << to_string(plan.error());
  EXPECT_NEAR(plan->duration(), 0.6 / 0.5 + 0.5 / 1, 2e-3);
  const double most = fastest(*plan).turn;
  EXPECT_LE(most, 1.001);
  EXPECT_GE(most, 0.99);
}

TEST_F(AcceleratedLines, AFractionAndAnAccelerationBothBind) {
  const Frame goal = start_ * translate(0, 0, 0.2);
  const auto time = [&](const Pace& pace) {
    return planner_.straight(ready_, goal, {}, pace).value().duration();
  };
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(time({.tool_acceleration = 3.1, .turn_acceleration = infinity}), time({}), 1e-4)
      << "the arm has 3 m/s²";
  EXPECT_NEAR(time({.acceleration = 0.1, .tool_acceleration = 2}), time({.acceleration = 0.1}),
              1e-4);
  EXPECT_GT(time({.acceleration = 0.1, .tool_acceleration = 0.2}),
            1.1 * time({.acceleration = 0.1}));
}

TEST_F(AcceleratedLines, NoLineExceedsTheAccelerationsThatWereAskedFor) {
  RandomJoints random(planner_.model(), 31);
  const Planner smooth(planner_.model(), tool_limits_, Smoothing::over(0.03, cycle));
  constexpr double slack = 1.001;
  int made = 0;
  for (int i = 0; i < 1000 && made < 300; ++i) {
    const JointValues from = random();
    const Pace pace{.tool_acceleration = 0.2 + 0.02 * (i % 100),
                    .turn_acceleration = 0.3 + 0.05 * (i % 200)};
    const auto move = planner_.straight_move(from, forward_.base_from_flange(random()), {}, pace);
    if (!move) continue;
    ++made;
    for (const Planner* const planner : {&std::as_const(planner_), &smooth}) {
      const Fastest most = fastest(planner->plan(*move));
      ASSERT_LE(most.way, std::min(*pace.tool_acceleration, 3.0) * slack) << "line " << i;
      ASSERT_LE(most.turn, std::min(*pace.turn_acceleration, 720_deg) * slack) << "line " << i;
    }
  }
  EXPECT_GE(made, 20);
}

TEST(SlowLines, DoNotExceedTheSpeedThatWasAskedFor) {
  constexpr double period = 0.01;           // s
  constexpr Pace pace{.tool_speed = 0.01};  // slow enough for joints beside a singularity
  const Frame tool = translate(0, 0, 150_mm);
  for (const auto& model : {rx90(), seven_axes()}) {
    Planner planner(model, {});
    RandomJoints random(model, 5);
    int made = 0;
    for (int i = 0; made < 60; ++i) {
      const JointValues from = random();
      const auto move =
          planner.straight_move(from, planner.base_from_tool(random(), tool), tool, pace);
      if (!move) continue;
      ++made;
      Playback playback(planner.plan(*move));
      Frame before = planner.base_from_tool(from, tool);
      double fastest = 0;
      while (!playback.standing()) {
        const Frame now = planner.base_from_tool(playback.advance(period), tool);
        fastest = std::max(fastest, distance(before, now) / period);
        before = now;
      }
      ASSERT_LE(fastest, 0.01 * 1.001) << "line " << i;
    }
  }
}

TEST_F(AcceleratedLines, ACornerIsAsSharpAsTheAccelerationAsksFor) {
  const Pace pace{.tool_speed = 0.25, .tool_acceleration = 1};
  const Frame corner = start_ * translate(0.15, 0, 0), goal = corner * translate(0, 0.15, 0);
  const auto first = planner_.straight_move(ready_, corner, {}, pace);
  ASSERT_TRUE(first) << to_string(first.error());
  const auto next = planner_.straight_move(first->goal(), goal, {}, pace);
  ASSERT_TRUE(next) << to_string(next.error());
  MoveChain chain(planner_, *first);
  const auto passed = chain.extend(*next, 0.1);
  ASSERT_TRUE(passed);
  const double miss = std::sqrt(2) * 0.25 * 0.25 / 8;  // |w - u| v²/8a, docs/motion.md
  EXPECT_NEAR(passed->distance, miss, 0.01 * miss);
}

TEST(Pace, AnAccelerationOfTheToolMustBeANumberThatTheArmCanMoveWith) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, 0.0, -1.0, 1e-7}) {
    EXPECT_NE(problem_of({.tool_acceleration = bad}).value_or("").find("tool_acceleration is"),
              std::string::npos);
    EXPECT_NE(problem_of({.turn_acceleration = bad}).value_or("").find("at least 1e-6 rad/s^2"),
              std::string::npos);
  }
  EXPECT_FALSE(problem_of({.tool_acceleration = 1e-6, .turn_acceleration = 1e-6}));
  EXPECT_TRUE(problem_of_joint_move({.turn_acceleration = 1}));
  EXPECT_TRUE(problem_of_joint_move({.speed = 2}));
  EXPECT_FALSE(problem_of_joint_move({.speed = 0.5, .tool_speed = 0.1}));
}

}  // namespace
}  // namespace robcl::motion
