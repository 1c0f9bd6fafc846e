// Goals at the edges of what an arm can do: each ends exactly, or is refused in words, and a
// refused one moves nothing.
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "rx90_fixture.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

robcl::Trajectory straight(robcl::Blend at_goal = robcl::Blend::BREAK) {
  return {.path = robcl::PathType::STRAIGHT, .at_goal = at_goal};
}

class Edges : public Rx90Laboratory {
 protected:
  void SetUp() override {
    Rx90Laboratory::SetUp();
    lease_.emplace(gecos::actor(robot_));
    ASSERT_TRUE(*lease_) << lease_->error();
  }

  /// The set points, which have no noise of the encoders.
  JointValues commanded() { return arm_.sample().commanded; }
  Frame tool() { return commanded_tool(); }
  template <class Command>
  auto ended(const Command& command) {
    return get(command, cycle());
  }
  void arrives(const Frame& goal, const robcl::Trajectory& how) {
    const auto moved = ended(robot_.move(goal, how));
    ASSERT_TRUE(moved) << moved.error();
    EXPECT_TRUE(near(tool(), goal, 1e-8, 1e-8)) << tool();
  }
  robcl::Joints at_degrees(const std::array<double, 6>& degrees) {
    robcl::Joints joints;
    for (std::size_t i = 0; i < 6; ++i) joints.position[i] = robcl::deg(degrees[i]);
    return joints;
  }
  void stands_at_degrees(const std::array<double, 6>& degrees) {
    const auto moved = ended(robot_.move_joints(at_degrees(degrees)));
    ASSERT_TRUE(moved) << moved.error();
  }
  /// Expects that `command` fails with a text that contains `words`, and moves nothing.
  template <class Command>
  void is_refused(Command command, gecos::Detail detail, const std::string& words) {
    const JointValues before = commanded();
    const auto refused = ended(command());
    ASSERT_FALSE(refused) << "not refused: " << words;
    EXPECT_EQ(refused.error().detail, detail) << refused.error();
    EXPECT_NE(refused.error().text.find(words), std::string::npos) << refused.error();
    for (int i = 0; i < 5; ++i) cycle()();
    EXPECT_EQ(commanded(), before) << words;
  }

  std::optional<decltype(gecos::actor(std::declval<robcl::Rx90&>()))> lease_;
};

TEST_F(Edges, WhereItStandsAndTurnsOfTheLeastAndTheGreatestAngleAreGoals) {
  const Frame start = tool();
  for (const robcl::Trajectory& how : {straight(), robcl::Trajectory{}}) {
    arrives(start, how);
    arrives(start * Frame::from_euler_zyz(0, 0, 0, 5e-7, 0, 0), how);
    arrives(start, how);
    arrives(start * Frame::from_euler_zyz(0, 0, 0, std::numbers::pi, 0, 0), how);
    arrives(start, how);
  }
}

TEST_F(Edges, WhatIsOutOfReachSaysByHowMuch) {
  // The wrist centre is .9 m from the shoulder when the arm is stretched.
  stands_at_degrees({0, 45, 0, 0, 45, 0});
  const Frame stretched = tool();
  stands_at_degrees({0, 45, 45, 0, 45, 0});
  const Frame further = translate(0.001 * std::sqrt(0.5), 0, 0.001 * std::sqrt(0.5)) * stretched;
  for (const robcl::Trajectory& how : {straight(), robcl::Trajectory{}}) {
    is_refused([&] { return robot_.move(further, how); }, gecos::Detail::Fault, "901.0 mm");
    is_refused([&] { return robot_.move(translate(500, 0, 300), how); }, gecos::Detail::Fault,
               "is the goal in millimetres?");
  }
}

TEST_F(Edges, DegreesInPlaceOfRadiansAreAskedAbout) {
  robcl::Joints degrees = robot_.joints().get().value();
  degrees.position[1] = 90;
  is_refused([&] { return robot_.move_joints(degrees); }, gecos::Detail::Fault,
             "JointLimit{axis=2, value=90 rad");
  is_refused([&] { return robot_.move_joints(degrees); }, gecos::Detail::Fault,
             "is the value in degrees?");
}

TEST_F(Edges, ALineThroughTheColumnIsRefusedWithItsCauseAndItsPlace) {
  stands_at_degrees({30, -20, 110, 0, 90, 0});  // behind the column, joint 1 is at -150
  const Frame start = tool();
  const Frame behind = translate(-2 * start.x(), -2 * start.y(), 0) * start;
  is_refused([&] { return robot_.move(behind, straight()); }, gecos::Detail::Fault,
             "mm along the line: joint 1 would have to turn ");
  arrives(start * translate(0, 0, 0.001), straight());
}

TEST_F(Edges, AJointLimitOnTheWaySaysWhereOnTheLineAndInWhichConfiguration) {
  stands_at_degrees({0, -20, 110, 0, 90, 260});
  robcl::arm::Kinematics forward(described_.model);
  JointValues turned = commanded();
  turned[5] += 20_deg;  // its limit is 270 degrees
  const Frame goal =
      translate(0, 0, -50_mm) * forward.base_from_flange(turned) * arm_.tool_offset();
  const auto line = [&] { return robot_.move(goal, straight()); };
  is_refused(line, gecos::Detail::Fault, "place=PlaceOnLine{way=");
  is_refused(line, gecos::Detail::Fault,
             "configuration=Configuration{arm=RIGHTY, bend=ABOVE, hand=FLIP}");
  const auto refused = ended(line());
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::JointLimit>();
  ASSERT_TRUE(why) << refused.error();
  EXPECT_EQ(why->axis, 6U);
  EXPECT_GT(why->value, why->upper);
  EXPECT_LT(why->value, why->upper + 1_deg);
  ASSERT_TRUE(why->place);
  EXPECT_NEAR(why->place->way, 25_mm, 1.1_mm);
  EXPECT_NEAR(why->place->turn, 10_deg, 0.5_deg);
  arrives(goal, robcl::Trajectory{});
}

TEST_F(Edges, JointsThatAreTurnedFurtherThanHalfATurnStaySo) {
  for (const double turned : {200.0, -200.0}) {
    stands_at_degrees({0, -20, 110, turned, 60, turned});
    arrives(tool() * translate(0, 0, -20_mm), straight());
    EXPECT_GT(std::abs(commanded()[3]), 150_deg);
    EXPECT_GT(std::abs(commanded()[5]), 150_deg);
  }
}

TEST_F(Edges, ReversalsRepeatedPointsAndTurnsInPlaceGoOverIntoEachOther) {
  const Frame start = tool();
  const Frame ahead = start * translate(0, 60_mm, 0);
  const Frame turned = ahead * Frame::from_euler_zyz(0, 0, 0, 0, 0, 0.4);
  const auto on = straight(robcl::Blend::NOBREAK);
  std::vector<decltype(robot_.move(start))> moves;
  for (const Frame& goal : {ahead, ahead, turned, ahead, start}) {
    moves.push_back(robot_.move(goal, on));
  }
  moves.push_back(robot_.move(ahead, robcl::Trajectory{.at_goal = robcl::Blend::NOBREAK}));
  moves.push_back(robot_.move(start, on));
  moves.push_back(robot_.move(turned, robcl::Trajectory{}));
  for (const auto& move : moves) {
    const auto moved = ended(move);
    ASSERT_TRUE(moved) << moved.error();
  }
  EXPECT_TRUE(near(tool(), turned, 1e-8, 1e-8)) << tool();
}

TEST_F(Edges, WhatIsNoGoalIsRefused) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(translate(nan, 0, 0), robcl::InvalidFrame);
  robcl::Joints joints = robot_.joints().get().value();
  joints.position[3] = nan;
  is_refused([&] { return robot_.move_joints(joints); }, gecos::Detail::BadParameter,
             "a joint position is not finite");
  for (const double slow : {-1.0, 0.0, 1e-8, 5e-324, nan}) {
    is_refused([&] { return robot_.move(tool(), robcl::Trajectory{.tool_speed = slow}); },
               gecos::Detail::Rejected, "but it must be at least 1e-6 m/s");
    is_refused([&] { return robot_.move(tool(), robcl::Trajectory{.turn_speed = slow}); },
               gecos::Detail::Rejected, "but it must be at least 1e-6 rad/s");
    auto how = straight();
    how.tool_acceleration = slow;
    is_refused([&] { return robot_.move(tool(), how); }, gecos::Detail::Rejected,
               "but it must be at least 1e-6 m/s^2");
    how = straight();
    how.turn_acceleration = slow;
    is_refused([&] { return robot_.move(tool(), how); }, gecos::Detail::Rejected,
               "but it must be at least 1e-6 rad/s^2");
  }
}

TEST_F(Edges, AnAccelerationOfTheToolIsForStraightMoves) {
  const robcl::Trajectory joint{.tool_acceleration = 0.5};
  const char* const words = "limit a straight move";
  is_refused([&] { return robot_.move(tool(), joint); }, gecos::Detail::Rejected, words);
  const robcl::Joints here = robot_.joints().get().value();
  is_refused([&] { return robot_.move_joints(here, joint); }, gecos::Detail::Rejected, words);
  auto how = straight();
  how.tool_acceleration = 0.5;
  how.turn_acceleration = 2;
  arrives(tool() * translate(0, 0, -50_mm), how);
}

}  // namespace
}  // namespace devices
