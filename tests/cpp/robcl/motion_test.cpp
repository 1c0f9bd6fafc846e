#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "allocations.hpp"
#include "arms.hpp"
#include "robcl/motion/planner.hpp"
#include "robcl/motion/playback.hpp"
#include "set_points.hpp"

namespace robcl::motion {
namespace {

using arm::ArmModel;

constexpr double cycle = 0.004;                             // s: 250 Hz
const JointValues ready = joints({0, -20, 110, 0, 90, 0});  // tool down in front of the arm

class Motion : public ::testing::Test {
 protected:
  const ArmModel model_ = rx90();
  const ToolLimits tool_limits_{};
  Planner planner_{model_, tool_limits_};
  arm::Kinematics forward_{model_};

  std::vector<JointValues> samples(const Plan& plan) {
    Playback playback(plan);
    std::vector<JointValues> all{plan.start()};
    while (!playback.standing()) all.push_back(playback.advance(cycle));
    all.push_back(playback.advance(cycle));
    return all;
  }

  void expect_within_limits(const std::vector<JointValues>& all, const Pace& pace) {
    motion::expect_within_limits(model_, all, pace, cycle);
  }
};

TEST_F(Motion, JointMovesKeepAllLimitsInEveryCycleAndArrive) {
  RandomJoints random(model_, 11);
  for (int i = 0; i < 200; ++i) {
    const JointValues from = random(), to = random();
    Pace pace;
    pace.speed = 0.1 + 0.009 * (i % 100);
    pace.acceleration = 1 - 0.009 * (i % 100);
    const auto plan = planner_.joints(from, to, pace);
    ASSERT_TRUE(plan.has_value());
    const auto all = samples(*plan);
    expect_within_limits(all, pace);
    ASSERT_EQ(all.back(), to);
  }
}

TEST_F(Motion, AJointMoveTakesTheTimeOfItsSlowestJointsTrapezoid) {
  JointValues to = ready;
  to[1] += 1.5;  // the slowest joint: 200 deg/s, full speed after 0.25 s
  to[5] += 0.2;
  const auto plan = planner_.joints(ready, to, {});
  ASSERT_TRUE(plan.has_value());
  EXPECT_NEAR(plan->law.duration(), 1.5 / 200_deg + 0.25, 1e-3);
}

TEST_F(Motion, JointsOfAJointMoveStayInProportion) {
  const JointValues to = joints({50, 10, 40, -60, 20, 100});
  const auto plan = planner_.joints(ready, to, {});
  const auto all = samples(*plan);
  for (const JointValues& q : all) {
    const double part = (q[0] - ready[0]) / (to[0] - ready[0]);
    ASSERT_LT((q - ready - part * (to - ready)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST_F(Motion, AMoveWhoseLimitsStopTheArmBeforeTheGoalIsRefused) {
  for (const double rise : {0.0, 0.03}) {
    const Planner planner(model_, tool_limits_, Smoothing::over(rise, cycle));
    auto move = planner_.joint_move(ready, joints({50, 10, 40, -60, 20, 100}), {}).value();
    const double unlimited = planner.plan(move).duration();
    move.caps.assign(move.path.intervals(), infinite);
    move.caps[50] = 0;  // at both ends of an interval
    EXPECT_FALSE(fastest_plan(
        move.path, model_, {limits_of(move, tool_limits_), braking_limits_of(move, tool_limits_)},
        planner.smoothing()));
    EXPECT_THROW(static_cast<void>(planner.plan(move)), std::runtime_error);
    move.caps[50] = 1e-6;
    EXPECT_GT(planner.plan(move).duration(), unlimited);
  }
}

TEST_F(Motion, AToolSpeedHoldsOnAJointMove) {
  Pace pace;
  pace.tool_speed = 0.25;
  const auto plan = planner_.joints(ready, joints({60, -40, 120, 30, 60, 0}), pace);
  ASSERT_TRUE(plan.has_value());
  const auto all = samples(*plan);
  double fastest = 0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    fastest = std::max(
        fastest,
        distance(forward_.base_from_flange(all[k - 1]), forward_.base_from_flange(all[k])) / cycle);
  }
  EXPECT_LE(fastest, 0.25 * slack);
  EXPECT_GE(fastest, 0.25 * 0.95);
}

TEST_F(Motion, AStraightMoveIsStraightTurnsAboutOneAxisAndKeepsAllLimits) {
  RandomJoints random(model_, 12);
  const Frame flange_from_tool = Frame::from_euler_zyz(0.02, 0, 0.12, 0.1, 0.2, 0.3);
  int made = 0;
  for (int i = 0; i < 600 && made < 120; ++i) {
    const JointValues from = random();
    const Frame start = planner_.base_from_tool(from, flange_from_tool);
    const Frame goal = planner_.base_from_tool(random(), flange_from_tool);
    Pace pace;
    pace.acceleration = 0.2 + 0.008 * (i % 100);
    const auto plan = planner_.straight(from, goal, flange_from_tool, pace);
    if (!plan) continue;
    ++made;
    const auto all = samples(*plan);
    expect_within_limits(all, pace);
    const Eigen::Vector3d direction = (goal.position() - start.position()).normalized();
    const double length = distance(start, goal), turn = angle(start, goal);
    Frame before = start;
    for (const JointValues& q : all) {
      const Frame tool = planner_.base_from_tool(q, flange_from_tool);
      const Eigen::Vector3d along = tool.position() - start.position();
      ASSERT_LT((along - direction * along.dot(direction)).norm(), 1e-5);
      const double part = along.dot(direction) / length;
      ASSERT_NEAR(angle(start, tool), part * turn, 1e-4);
      ASSERT_NEAR(angle(tool, goal), (1 - part) * turn, 1e-4);
      ASSERT_LE(distance(before, tool) / cycle, tool_limits_.speed * slack);
      ASSERT_LE(angle(before, tool) / cycle, tool_limits_.turn_speed * slack);
      before = tool;
    }
    ASSERT_TRUE(near(before, goal, 1e-9, 1e-9));
  }
  EXPECT_GE(made, 60);
}

TEST_F(Motion, AStraightMoveIsATrapezoidWhereOnlyTheToolsLimitsBind) {
  const Frame start = forward_.base_from_flange(ready);
  Pace pace;
  pace.tool_speed = 0.2;
  const auto plan = planner_.straight(ready, start * translate(0, 0, 0.2), Frame(), pace);
  ASSERT_TRUE(plan.has_value()) << to_string(plan.error());
  EXPECT_NEAR(plan->law.duration(), 0.2 / 0.2 + 0.2 / 3.0, 2e-3);
}

TEST_F(Motion, AMoveThatLastsDaysIsFoundAsFastAsAnyOther) {
  const Planner planner(model_, tool_limits_, Smoothing::over(0.03, 0.001));
  const Frame goal = forward_.base_from_flange(ready) * translate(0, 0, 0.2);
  const auto move = planner_.straight_move(ready, goal, Frame(), {.tool_speed = 1e-6});
  ASSERT_TRUE(move);
  EXPECT_NEAR(planner.plan(*move).duration(), 0.2 / 1e-6, 0.02 * 0.2 / 1e-6);  // s
}

TEST_F(Motion, AStraightMoveKeepsItsConfiguration) {
  const Frame start = forward_.base_from_flange(ready);
  const auto plan = planner_.straight(ready, start * translate(0.1, 0.2, 0.1), Frame(), {});
  ASSERT_TRUE(plan.has_value());
  for (const JointValues& q : samples(*plan)) {
    ASSERT_EQ(planner_.configuration(q), planner_.configuration(ready));
  }
}

TEST_F(Motion, AStraightMoveNearTheWristSingularityIsSlowedDown) {
  const JointValues from = joints({0, -30, 90, 0, 30, 0});
  const Frame start = forward_.base_from_flange(from);
  // Past joint 5 = 0 at a small distance, as seen in how long it takes.
  const Frame goal = forward_.base_from_flange(joints({0, -30, 90, 150, 30, 0}));
  const auto plan = planner_.straight(from, goal, Frame(), {});
  ASSERT_TRUE(plan.has_value()) << to_string(plan.error());
  const double unhindered = std::max(distance(start, goal) / 1.0, angle(start, goal) / 180_deg);
  EXPECT_GT(plan->law.duration(), unhindered * 1.2);
  expect_within_limits(samples(*plan), {});
}

TEST_F(Motion, AStraightMoveThroughTheWristSingularityIsRefused) {
  const JointValues from = joints({0, -30, 90, 0, 30, 0});
  const Frame goal = forward_.base_from_flange(joints({0, -30, 90, 0, -30, 0}));
  const auto plan = planner_.straight(from, goal, Frame(), {});
  ASSERT_FALSE(plan.has_value());
  const auto* singular = std::get_if<arm::Singular>(&plan.error());
  ASSERT_NE(singular, nullptr) << to_string(plan.error());
  EXPECT_NE(singular->reason.find("joint 4 would have to turn"), std::string::npos)
      << singular->reason;
  EXPECT_LE(singular->reason.size(), 160u);
  EXPECT_TRUE(planner_.joints_to(from, goal, Frame(), {}).has_value());
}

TEST_F(Motion, AStraightMoveThatLeavesTheReachOnTheWaySaysWhere) {
  // The Puma's arm is beside its column, so its wrist comes no nearer to axis 1 than 150 mm.
  Planner puma(puma560(), tool_limits_);
  const Frame front = translate(0.4, -0.1, 0.5);
  const auto to_front = puma.joints_to(joints({0, 45, -135, 0, 45, 0}), front, Frame(), {});
  ASSERT_TRUE(to_front.has_value());
  const Frame back = translate(-0.8, 0, 0) * front;
  const auto plan = puma.straight(to_front->goal(), back, Frame(), {});
  ASSERT_FALSE(plan.has_value());
  const auto* reach = std::get_if<arm::OutOfReach>(&plan.error());
  ASSERT_NE(reach, nullptr) << to_string(plan.error());
  EXPECT_EQ(reach->reason,
            "289.0 mm along the line: the wrist centre would be 149.4 mm from axis 1, but this "
            "distance must be at least 150.1 mm");
  EXPECT_TRUE(puma.joints_to(to_front->goal(), back, Frame(), {}).has_value());
}

TEST_F(Motion, AGoalInMillimetresIsAskedAbout) {
  const auto plan = planner_.straight(ready, translate(500, 0, 300), Frame(), {});
  ASSERT_FALSE(plan.has_value());
  const auto* reach = std::get_if<arm::OutOfReach>(&plan.error());
  ASSERT_NE(reach, nullptr);
  EXPECT_EQ(
      reach->reason,
      "the goal is 583.1 m from the base, the arm reaches 1.405 m: is the goal in millimetres?");
  EXPECT_FALSE(planner_.joints_to(ready, translate(500, 0, 300), Frame(), {}).has_value());
}

TEST_F(Motion, AJointGoalOutsideTheLimitsNamesTheJoint) {
  const auto plan = planner_.joints(ready, joints({0, 0, 0, 0, -110, 0}), {});
  ASSERT_FALSE(plan.has_value());
  EXPECT_EQ(to_string(plan.error()),
            "joint 5 would have to stand at -110.0 deg, but its range is -105.0 to 120.0 deg");
}

TEST_F(Motion, AJointGoalThatIsNoNumberIsRefused) {
  JointValues to = ready;
  to[2] = std::nan("");
  const auto plan = planner_.joints(ready, to, {});
  ASSERT_FALSE(plan.has_value());
  const auto* limit = std::get_if<arm::JointLimit>(&plan.error());
  ASSERT_NE(limit, nullptr);
  EXPECT_EQ(limit->axis, 3u);
}

TEST_F(Motion, AMoveToWhereItStandsIsOverAtOnce) {
  const auto plan = planner_.straight(ready, forward_.base_from_flange(ready), Frame(), {});
  ASSERT_TRUE(plan.has_value());
  Playback playback(*plan);
  EXPECT_EQ(playback.advance(cycle), ready);
  EXPECT_TRUE(playback.standing());
  EXPECT_EQ(playback.fraction(), 1);
  Playback held_up(*plan);
  held_up.rest();
  EXPECT_EQ(held_up.advance(cycle), ready);
  EXPECT_TRUE(held_up.standing());
}

TEST_F(Motion, StopDeceleratesOnThePathWithinTheLimits) {
  RandomJoints random(model_, 13);
  const Frame start = forward_.base_from_flange(ready);
  const Frame goal = start * Frame::from_euler_zyz(0.2, -0.3, 0.1, 0.5, 0.5, 0);
  const auto plan = planner_.straight(ready, goal, Frame(), {});
  ASSERT_TRUE(plan.has_value()) << to_string(plan.error());
  const Eigen::Vector3d direction = (goal.position() - start.position()).normalized();
  const auto cycles = static_cast<int>(plan->law.duration() / cycle);
  for (int stop_at = 1; stop_at < cycles; stop_at += 3) {
    Playback playback(*plan);
    std::vector<JointValues> all{ready};
    for (int k = 0; k < stop_at; ++k) all.push_back(playback.advance(cycle));
    playback.stop();
    int braking = 0;
    while (!playback.standing()) {
      all.push_back(playback.advance(cycle));
      ASSERT_LT(++braking, 250) << "does not stand";
    }
    all.push_back(playback.advance(cycle));
    expect_within_limits(all, {});
    for (const JointValues& q : all) {
      const Eigen::Vector3d along = forward_.base_from_flange(q).position() - start.position();
      ASSERT_LT((along - direction * along.dot(direction)).norm(), 1e-6);
    }
    EXPECT_LE(braking * cycle, 0.4) << "stopped after cycle " << stop_at;
  }
}

TEST_F(Motion, ProgressRisesToOneWhileTheRemainingTimeFalls) {
  const auto plan = planner_.joints(ready, joints({30, 0, 90, 0, 90, 0}), {});
  Playback playback(*plan);
  double fraction = 0, remaining = plan->law.duration();
  while (!playback.standing()) {
    playback.advance(cycle);
    ASSERT_GE(playback.fraction(), fraction);
    ASSERT_LE(playback.remaining(), remaining);
    fraction = playback.fraction();
    remaining = playback.remaining();
  }
  EXPECT_EQ(fraction, 1);
  EXPECT_EQ(remaining, 0);
}

TEST_F(Motion, PlayingBackAndStoppingAllocatesNothing) {
  const auto plan = planner_.straight(
      ready, forward_.base_from_flange(ready) * translate(0, 0.1, 0.1), Frame(), {});
  Playback playback(*plan);
  CountAllocations allocations;
  JointValues sum = playback.advance(cycle);
  for (int k = 0; k < 30; ++k) sum += playback.advance(cycle);
  playback.stop();
  while (!playback.standing()) sum += playback.advance(cycle);
  EXPECT_EQ(allocations.so_far(), 0);
  EXPECT_TRUE(sum.allFinite());
}

TEST_F(Motion, ASlowMoveWhoseOverrideChangesEnds) {
  const Smoothing smoothing = Smoothing::over(0.03, cycle);
  Planner planner(model_, {}, smoothing);
  Pace pace;
  pace.tool_speed = 1e-4;
  const Frame goal = translate(0, 0, 2.5e-5) * planner.base_from_tool(ready, {});
  const Plan plan = planner.straight(ready, goal, {}, pace).value();
  const auto cycles = static_cast<int>(plan.duration() / cycle);
  for (const double factor : {0.0, 0.01, 0.1, 0.5}) {
    for (int at = 1; at < cycles; ++at) {
      Playback playback(plan);
      for (int i = 0; i < at; ++i) playback.advance(cycle);
      playback.set_override(factor);
      for (int i = 0; i < 3; ++i) playback.advance(cycle);
      playback.set_override(1);
      for (int i = 0; !playback.standing() && i < 1000; ++i) playback.advance(cycle);
      ASSERT_TRUE(playback.standing()) << factor << " in cycle " << at << " of " << cycles;
      EXPECT_EQ(playback.advance(cycle), plan.goal());
    }
  }
}

TEST_F(Motion, AnOverrideScalesTheSpeedAndZeroPausesUntilItIsRaised) {
  const Frame goal = planner_.base_from_tool(ready, {}) * translate(0, 0, -0.2);
  const Plan plan = planner_.straight(ready, goal, {}, {}).value();
  Playback playback(plan);
  playback.set_override(0.5);
  double time = 0;
  for (; !playback.standing(); time += cycle) playback.advance(cycle);
  EXPECT_NEAR(time, 2 * plan.law.duration(), 0.2 * plan.law.duration());

  Playback paused(plan);
  for (int i = 0; i < 20; ++i) paused.advance(cycle);
  paused.set_override(0);
  for (int i = 0; i < 500; ++i) paused.advance(cycle);
  const JointValues held = paused.advance(cycle);
  EXPECT_EQ(paused.advance(cycle), held);
  EXPECT_FALSE(paused.standing()) << "it goes on later";
  EXPECT_GT(paused.remaining(), 0);
  paused.set_override(1);
  for (int i = 0; !paused.standing() && i < 10'000; ++i) paused.advance(cycle);
  EXPECT_EQ(paused.advance(cycle), plan.goal());

  Playback stopped(plan);
  for (int i = 0; i < 20; ++i) stopped.advance(cycle);
  stopped.set_override(0);
  for (int i = 0; i < 500; ++i) stopped.advance(cycle);
  stopped.stop();
  stopped.advance(cycle);
  EXPECT_TRUE(stopped.standing()) << "a paused motion can be stopped";
}

TEST(Paths, AJointThatGoesTooFarBetweenTwoKnotsIsFound) {
  const ArmModel model = rx90();
  Path::Knots knots;
  const double upper = model.limits()[1].upper;
  const std::array<double, 5> below{0.3, 0.1, 0.01, 0.01, 0.1};
  for (std::size_t i = 0; i < below.size(); ++i) {
    JointValues at = ready;
    at[1] = upper - below[i];
    knots.add(static_cast<double>(i), at);
  }
  const Path path(knots);
  double highest = 0;
  for (double s = 0; s < path.end(); s += 1e-4) highest = std::max(highest, path.position(s)[1]);
  ASSERT_GT(highest, upper);
  double found = 0;
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    found = std::max(found, path.range(i).highest[1]);
  }
  EXPECT_NEAR(found, highest, 1e-8);
  const auto outside = first_outside(model, path);
  ASSERT_TRUE(outside);
  EXPECT_EQ(outside->limit.axis, 2U);
  EXPECT_NEAR(outside->limit.value, highest, 1e-8);
  EXPECT_EQ(outside->s, 2) << "between the knots 2 and 3";
  EXPECT_FALSE(first_outside(model, Path({{0, 1}, {ready, ready}})));
}

/// A path on which joint 2 is beyond a limit by these angles in rad, at one knot after the other;
/// angles below 0 are inside. The limit is the upper one if `side` is 1, the lower one if -1.
std::optional<OutsideOnPath> outside_on_path(double side, const std::vector<double>& beyond) {
  const ArmModel model = rx90();
  const arm::JointLimits& limits = model.limits()[1];
  Path::Knots knots;
  for (std::size_t i = 0; i < beyond.size(); ++i) {
    JointValues at = ready;
    at[1] = (side > 0 ? limits.upper : limits.lower) + side * beyond[i];
    knots.add(static_cast<double>(i), at);
  }
  return first_outside(model, Path(knots));
}

TEST(Paths, AJointThatStartsBeyondItsLimitMayReturnButNotLeaveItAgain) {
  for (const double side : {1.0, -1.0}) {
    SCOPED_TRACE(side);
    EXPECT_FALSE(outside_on_path(side, {1e-3, 0.0, -1e-3, -2e-3}));
    EXPECT_FALSE(outside_on_path(side, {4e-3, 3e-3, 2e-3, 1e-3, 0.0, -1e-3}));
    const auto further = outside_on_path(side, {1e-3, 2e-3, 1e-3, 0.0, -1e-3});
    ASSERT_TRUE(further);
    EXPECT_EQ(further->limit.axis, 2U);
    EXPECT_EQ(further->s, 0);
    EXPECT_EQ(further->limit.upper, rx90().limits()[1].upper);
    const auto again = outside_on_path(side, {1e-3, 0.0, -1e-3, -2e-3, 0.0, 0.5e-3, 0.0, -1e-3});
    ASSERT_TRUE(again);
    EXPECT_GE(again->s, 3);
    EXPECT_LE(again->s, 4);
    const auto stays = outside_on_path(side, {1e-3, 0.8e-3, 0.6e-3, 0.4e-3});
    ASSERT_TRUE(stays);
    EXPECT_EQ(stays->s, 2) << "the last interval";
  }
}

TEST(Pace, ItsProblemIsNamed) {
  EXPECT_EQ(problem_of({}), std::nullopt);
  Pace pace;
  pace.speed = 0;
  EXPECT_EQ(problem_of(pace), "speed is 0, but it must be above 0, at most 1");
  pace = {};
  pace.tool_speed = std::nan("");
  EXPECT_TRUE(problem_of(pace).has_value());
}

}  // namespace
}  // namespace robcl::motion
