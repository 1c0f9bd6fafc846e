#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "../robcl/allocations.hpp"
#include "devices/support/periodic.hpp"
#include "rx90_fixture.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;
using namespace std::chrono_literals;
using Rx90Test = Rx90Laboratory;

TEST_F(Rx90Test, StandsAtTheGoalWhenAMoveIsFinishedAlsoWithNoBreakIfNoneFollows) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const Frame goal = robot_.tool().get().value() * translate(0, 50_mm, 0);
  for (const robcl::Blend at_goal : {robcl::Blend::BREAK, robcl::Blend::NOBREAK}) {
    const Frame there = at_goal == robcl::Blend::BREAK ? goal : goal * translate(50_mm, 0, 0);
    const auto moved = get(robot_.move(there, robcl::Trajectory{.at_goal = at_goal}), cycle());
    ASSERT_TRUE(moved) << moved.error();
    EXPECT_FALSE(arm_.moving());
    EXPECT_LT(distance(robot_.tool().get().value(), there), 1e-4);
  }
}

TEST_F(Rx90Test, WithNoBreakTheArmRoundsTheCornerAndSaysHowFarItPassesTheGoal) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const Frame start = robot_.tool().get().value();
  const Frame tool = robot_.tool_offset().get().value();
  const auto straight = [&](const Frame& goal, robcl::Blend at_goal) {
    return robot_.move(
        goal, robcl::Trajectory{
                  .path = robcl::PathType::STRAIGHT, .at_goal = at_goal, .tool_speed = 0.25});
  };
  const Periodic control(4ms, [this](double seconds) { arm_.step(seconds); });
  const auto first = straight(start * translate(0, 200_mm, 0), robcl::Blend::NOBREAK);
  const auto second = straight(start * translate(0, 200_mm, -100_mm), robcl::Blend::NOBREAK);
  const auto last = straight(start, robcl::Blend::BREAK);
  const auto after = robot_.set_tool_offset(tool * translate(0, 0, 10_mm));
  ASSERT_TRUE(first.get()) << first.get().error();
  EXPECT_TRUE(arm_.moving());
  ASSERT_TRUE(first.feedback()->corner);
  EXPECT_NEAR(*first.feedback()->corner, std::sqrt(2) * 0.25 * 0.25 / (8 * 3.0), 0.0005);
  ASSERT_TRUE(second.get()) << second.get().error();
  EXPECT_EQ(after.state(), gecos::State::Running);
  ASSERT_TRUE(last.get()) << last.get().error();
  EXPECT_FALSE(last.feedback()->corner);
  ASSERT_TRUE(after.get()) << after.get().error();
  EXPECT_LT(distance(robot_.tool().get().value(), start * translate(0, 0, 10_mm)), 1e-4);
}

TEST_F(Rx90Test, FiftyShortMovesAskedForInOneMomentTakeTheTimeOfOneLine) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const Frame start = robot_.tool().get().value();
  const auto move_to = [&](double way, robcl::Blend at_goal) {
    return robot_.move(start * translate(0, 0, -way),
                       robcl::Trajectory{.path = robcl::PathType::STRAIGHT, .at_goal = at_goal});
  };
  // The time of the arm. It passes slowly, because planning takes real time on any machine.
  int cycles = 0;
  const auto slow_cycle = [&] {
    arm_.step(0.004);
    ++cycles;
    std::this_thread::sleep_for(15ms);
  };
  ASSERT_TRUE(get(move_to(200_mm, robcl::Blend::BREAK), slow_cycle));
  const int one_line = std::exchange(cycles, 0);
  std::vector<decltype(move_to(0, {}))> moves;
  for (int left = 49; left >= 0; --left) {
    moves.push_back(move_to(left * 4_mm, left > 0 ? robcl::Blend::NOBREAK : robcl::Blend::BREAK));
  }
  const auto moved = get(moves.back(), slow_cycle);
  ASSERT_TRUE(moved) << moved.error();
  for (const auto& move : moves) EXPECT_TRUE(move.get()) << move.get().error();
  EXPECT_LE(cycles, 1.05 * one_line);
  EXPECT_LT(distance(robot_.tool().get().value(), start), 1e-4);
}

TEST_F(Rx90Test, ACanceledMoveCancelsThoseThatItWasToGoOverInto) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const Frame start = robot_.tool().get().value();
  const Frame goal = start * translate(0, 300_mm, 0);
  const Periodic control(4ms, [this](double seconds) { arm_.step(seconds); });
  const robcl::Trajectory how{
      .path = robcl::PathType::STRAIGHT, .at_goal = robcl::Blend::NOBREAK, .tool_speed = 0.1};
  const auto first = robot_.move(goal, how), second = robot_.move(start, how);
  while (!first.feedback() || !first.feedback()->corner) std::this_thread::yield();
  first.cancel();
  for (const auto* const move : {&first, &second}) {
    const auto ended = move->get();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, gecos::Detail::Canceled) << ended.error();
  }
  EXPECT_FALSE(arm_.moving());
  EXPECT_GT(distance(robot_.tool().get().value(), goal), 50_mm);
}

TEST_F(Rx90Test, AJointThatCannotTurnSoFarIsNamedCountedFromOne) {
  const auto lease = gecos::actor(robot_);
  robcl::Joints target = robot_.joints().get().value();
  target.position[1] = 200_deg;
  const auto refused = get(robot_.move_joints(target), cycle());
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::JointLimit>();
  ASSERT_TRUE(why.has_value()) << refused.error();
  EXPECT_EQ(why->axis, 2U);
  EXPECT_NEAR(why->value, 200_deg, 1e-9);
  EXPECT_LT(why->upper, why->value);
  EXPECT_EQ(refused.error().text.rfind("JointLimit{axis=2, value=", 0), 0U) << refused.error().text;
}

TEST_F(Rx90Test, AGoalOutOfReachIsRefusedAndTheArmDoesNotMove) {
  const auto lease = gecos::actor(robot_);
  const auto refused = get(robot_.move(translate(5, 0, 0)), cycle());
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().as<robcl::OutOfReach>().has_value()) << refused.error();
  EXPECT_FALSE(arm_.moving());
}

TEST_F(Rx90Test, StoppedByAnotherProgramItStandsOnItsWayAndTellsWhenItStands) {
  const auto lease = gecos::actor(robot_);
  auto stood = robot_.stood(gecos::stream);
  ASSERT_TRUE(stood) << stood.error();
  const Frame start = arm_.sample().tool;
  const Frame goal = start * translate(0, 300_mm, 0);
  const Periodic control(4ms, [this](double seconds) {  // as on the real arm
    arm_.step(seconds);
    servant_.publish();
  });
  const auto moving = robot_.move(goal, robcl::Trajectory{.speed = 0.05});  // for seconds
  while (distance(arm_.sample().tool, start) < 1e-3) std::this_thread::yield();
  EXPECT_FALSE(robot_.standing().get().value());
  EXPECT_FALSE(stood->next(0ms));

  gecos::Lab other;
  ASSERT_TRUE(gecos::stop(other.create<robcl::Manipulator>("RX90").value()).get());
  const auto stopped = get(moving, [] {});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().detail, gecos::Detail::Stopped);
  const auto rest = stood->next(10s);
  ASSERT_TRUE(rest) << "no event tells that it stands";
  EXPECT_TRUE(robot_.standing().get().value());
  EXPECT_LT(distance(arm_.sample().tool, rest->value.tool), 1e-4);
  EXPECT_GT(distance(arm_.sample().tool, goal), 100_mm);
}

TEST_F(Rx90Test, AMotionIsPausedAndGoesOnByTheOverrideOfItsSpeed) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto stood = robot_.stood(gecos::stream);
  ASSERT_TRUE(stood) << stood.error();
  const Frame goal = robot_.tool().get().value() * translate(0, 0, -100_mm);
  EXPECT_EQ(robot_.speed_override().get().value(), 1);
  EXPECT_TRUE(robot_.standing().get().value());
  const auto move =
      robot_.move(goal, robcl::Trajectory{.path = robcl::PathType::STRAIGHT, .tool_speed = 0.1});
  while (move.wait_for(1ms) == gecos::State::Running) {  // progress comes every 5 ms
    cycle()();
    if (move.feedback() && move.feedback()->fraction > 0.1) break;
  }
  EXPECT_FALSE(robot_.standing().get().value());

  ASSERT_TRUE(get(robot_.override_speed(0), cycle()));
  for (int i = 0; i < 300; ++i) cycle()();
  const Frame paused = robot_.tool().get().value();
  for (int i = 0; i < 50; ++i) cycle()();
  EXPECT_LT(distance(robot_.tool().get().value(), paused), 1e-4);
  EXPECT_EQ(move.state(), gecos::State::Running);
  EXPECT_FALSE(stood->next(0ms)) << "a paused motion has not come to rest";

  ASSERT_TRUE(get(robot_.override_speed(0.5), cycle()));
  EXPECT_EQ(robot_.speed_override().get().value(), 0.5);
  ASSERT_TRUE(get(move, cycle())) << move.get().error();
  EXPECT_LT(distance(robot_.tool().get().value(), goal), 1e-4);
  cycle()();
  const auto rest = stood->next(1s);
  ASSERT_TRUE(rest);
  EXPECT_LT(distance(rest->value.tool, goal), 1e-4);
  EXPECT_EQ(robot_.missed_cycles().get().value(), 0U);
  const auto faster = robot_.override_speed(1.5).get();
  ASSERT_FALSE(faster);
  EXPECT_EQ(faster.error().detail, gecos::Detail::BadParameter) << faster.error();
}

TEST_F(Rx90Test, ANewToolAndANewPlaceTakeTheirTurnBehindAMotion) {
  const auto lease = gecos::actor(robot_);
  const Frame tool = robot_.tool_offset().get().value();
  const Frame start = robot_.tool().get().value();
  const Frame goal = start * translate(0, 0, -50_mm);
  const auto move = robot_.move(goal);
  const auto longer = robot_.set_tool_offset(tool * translate(0, 0, 10_mm));
  const auto mount = robot_.mount("", translate(1, 0, 0));
  ASSERT_TRUE(get(move, cycle())) << move.get().error();
  ASSERT_TRUE(get(longer, cycle())) << longer.get().error();
  ASSERT_TRUE(get(mount, cycle())) << mount.get().error();
  cycle()();
  EXPECT_TRUE(near(robot_.tool().get().value(), translate(1, 0, 0) * goal * translate(0, 0, 10_mm),
                   1e-4, 1e-3));
}

TEST_F(Rx90Test, AGoalFromBeforeTheBaseGotAnotherPlaceIsRefused) {
  const auto lease = gecos::actor(robot_);
  const std::uint64_t epoch = robot_.pose_epoch().get().value();
  const Frame goal = robot_.tool().get().value() * translate(0, 0, -10_mm);
  ASSERT_TRUE(get(robot_.move(goal, std::nullopt, epoch), cycle()));
  const auto mount = robot_.mount("", translate(0, 0, 100_mm));
  const auto stale = get(robot_.move(goal, std::nullopt, epoch), cycle());
  ASSERT_TRUE(mount.get());
  ASSERT_FALSE(stale);
  EXPECT_EQ(stale.error().detail, gecos::Detail::Rejected) << stale.error();
  EXPECT_NE(stale.error().text.find("read the base and compute the goal again"), std::string::npos)
      << stale.error();
  EXPECT_FALSE(arm_.moving());
  EXPECT_NE(robot_.pose_epoch().get().value(), epoch);
}

TEST_F(Rx90Test, StreamsOfMeasuredAndCommandedJointsTellOfTheSameCycle) {
  const auto lease = gecos::actor(robot_);
  auto measured = robot_.joints(gecos::stream).value();
  auto commanded = robot_.commanded_joints(gecos::stream).value();
  robcl::Joints target = robot_.joints().get().value();
  target.position[0] += 0.2;
  double lag = 0;
  double command = 0;
  ASSERT_TRUE(get(robot_.move_joints(target), [&] {
    cycle()();
    const auto set = commanded.next(0ms);
    const auto read = measured.next(0ms);
    ASSERT_TRUE(set && read);
    EXPECT_EQ(set->stamp, read->stamp);
    command = set->value.position[0];
    lag = std::max(lag, std::abs(command - read->value.position[0]));
  }));
  EXPECT_GT(lag, 1e-3) << "the simulated servos follow their set points at some distance";
  EXPECT_NEAR(command, target.position[0], 1e-9);
}

TEST_F(Rx90Test, TheControlLoopPublishesWithoutAllocating) {
  const auto joints = robot_.joints(gecos::stream);
  const auto commanded = robot_.commanded_joints(gecos::stream);
  const auto tool = robot_.tool(gecos::stream);
  const auto flange = robot_.flange(gecos::stream);
  ASSERT_TRUE(joints && commanded && tool && flange);
  for (int i = 0; i < 100; ++i) cycle()();
  const robcl::CountAllocations count;
  for (int i = 0; i < 1000; ++i) cycle()();
  EXPECT_EQ(count.so_far(), 0);
}

TEST_F(Rx90Test, AJointMoveEndsInTheConfigurationThatIsAskedForAndAStraightMoveKeepsIt) {
  const auto lease = gecos::actor(robot_);
  EXPECT_EQ(
      robot_.posture().get().value(),
      (robcl::Configuration{robcl::Shoulder::RIGHTY, robcl::Elbow::ABOVE, robcl::Wrist::FLIP}));
  const Frame here = robot_.tool().get().value();
  const robcl::Configuration noflip{.hand = robcl::Wrist::NOFLIP};
  const auto straight = get(
      robot_.move(here * translate(0, 0, -10_mm),
                  robcl::Trajectory{.path = robcl::PathType::STRAIGHT, .configuration = noflip}),
      cycle());
  ASSERT_FALSE(straight);
  EXPECT_EQ(straight.error().detail, gecos::Detail::Rejected) << straight.error();
  EXPECT_NE(straight.error().text.find(
                "a straight move keeps the configuration righty, above, flip and cannot end as "
                "any, any, noflip; use a joint move"),
            std::string::npos)
      << straight.error();
  ASSERT_TRUE(get(robot_.move(here, robcl::Trajectory{.configuration = noflip}), cycle()));
  EXPECT_TRUE(near(robot_.tool().get().value(), here, 1e-4, 1e-3));
  EXPECT_EQ(
      robot_.posture().get().value(),
      (robcl::Configuration{robcl::Shoulder::RIGHTY, robcl::Elbow::ABOVE, robcl::Wrist::NOFLIP}));
  ASSERT_TRUE(get(
      robot_.move(here * translate(0, 0, -10_mm),
                  robcl::Trajectory{.path = robcl::PathType::STRAIGHT, .configuration = noflip}),
      cycle()))
      << "the present configuration may be asked for";
}

TEST_F(Rx90Test, TheConfigurationThatIsSetIsThatOfTheNextJointMoveOfTheSameSession) {
  const auto lease = gecos::actor(robot_);
  const Frame here = robot_.tool().get().value();
  const auto hand = [&] { return robot_.posture().get().value().hand; };
  ASSERT_EQ(hand(), robcl::Wrist::FLIP);
  ASSERT_TRUE(get(robot_.set_configuration({.hand = robcl::Wrist::NOFLIP}), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::FLIP) << "it moves nothing itself";
  ASSERT_TRUE(get(robot_.move(here * translate(0, 0, -10_mm),
                              robcl::Trajectory{.path = robcl::PathType::STRAIGHT}),
                  cycle()));
  ASSERT_TRUE(get(robot_.move(here), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::NOFLIP);
  ASSERT_TRUE(get(robot_.move(here * translate(0, 0, -10_mm)), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::NOFLIP) << "moves keep it";

  // The option of the move has precedence, and uses up what was set.
  ASSERT_TRUE(get(robot_.set_configuration({.hand = robcl::Wrist::NOFLIP}), cycle()));
  const robcl::Configuration flip{.hand = robcl::Wrist::FLIP};
  ASSERT_TRUE(get(robot_.move(here, robcl::Trajectory{.configuration = flip}), cycle()));
  ASSERT_TRUE(get(robot_.move(here * translate(0, 0, -10_mm)), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::FLIP);
}

TEST_F(Rx90Test, TheConfigurationThatIsSetIsNotThatOfAnotherSessionWithTheSameStatus) {
  const auto lease = gecos::actor(robot_, "two hands");
  ASSERT_TRUE(lease) << lease.error();
  gecos::Lab elsewhere;
  const auto other = elsewhere.create<robcl::Rx90>("RX90").value();
  const auto shared = gecos::actor(other, "two hands");
  ASSERT_TRUE(shared) << shared.error();
  const Frame here = robot_.tool().get().value();
  const auto hand = [&] { return robot_.posture().get().value().hand; };
  ASSERT_TRUE(get(robot_.set_configuration({.hand = robcl::Wrist::NOFLIP}), cycle()));
  ASSERT_TRUE(get(other.move(here * translate(0, 0, -10_mm)), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::FLIP);
  ASSERT_TRUE(get(robot_.move(here), cycle()));
  EXPECT_EQ(hand(), robcl::Wrist::NOFLIP);
}

TEST_F(Rx90Test, AStopAndTheEndOfTheStatusLetTheConfigurationThatIsSetBeForgotten) {
  const Frame here = robot_.tool().get().value();
  for (const bool stops : {true, false}) {
    {
      const auto lease = gecos::actor(robot_);
      ASSERT_TRUE(get(robot_.set_configuration({.hand = robcl::Wrist::NOFLIP}), cycle()));
      if (stops) {
        ASSERT_TRUE(gecos::stop(robot_).get());
      }
    }
    const auto lease = gecos::actor(robot_);
    ASSERT_TRUE(lease) << lease.error();
    ASSERT_TRUE(get(robot_.move(here * translate(0, 0, -10_mm)), cycle()));
    EXPECT_EQ(robot_.posture().get().value().hand, robcl::Wrist::FLIP) << stops;
  }
}

TEST_F(Rx90Test, AJointMoveThatIsRefusedDoesNotUseUpTheConfigurationThatIsSet) {
  const auto lease = gecos::actor(robot_);
  const Frame here = robot_.tool().get().value();
  ASSERT_TRUE(get(robot_.set_configuration({.hand = robcl::Wrist::NOFLIP}), cycle()));
  ASSERT_FALSE(get(robot_.move(here * translate(5, 0, 0)), cycle()));
  ASSERT_TRUE(get(robot_.move(here), cycle()));
  EXPECT_EQ(robot_.posture().get().value().hand, robcl::Wrist::NOFLIP);
}

TEST_F(Rx90Test, AMoveThatIsPausedBecauseTheFactorOfTheSpeedIsZeroSaysSo) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(robot_.override_speed(0).get());
  const auto move = robot_.move(robot_.tool().get().value() * translate(0, 50_mm, 0));
  const auto shown = [&] {
    const auto told = move.feedback();
    return told ? told->speed_override : std::nullopt;
  };
  while (!shown()) cycle()();
  EXPECT_EQ(shown(), 0);
  ASSERT_TRUE(robot_.override_speed(1).get());
  ASSERT_TRUE(get(move, cycle())) << move.get().error();
  EXPECT_FALSE(shown());
}

TEST_F(Rx90Test, AFactorOfTheSpeedThatIsRefusedIsNamedWithoutAUnit) {
  const auto lease = gecos::actor(robot_);
  const auto refused = robot_.override_speed(2).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "override_speed.factor: 2 is outside [0.0, 1.0]; give at most 1.0");
}

TEST_F(Rx90Test, StandsOnTheFloorAndOnNoOtherArm) {
  const auto lease = gecos::actor(robot_);
  const auto refused = robot_.mount("PUMA", Frame()).get();
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().as<robcl::MountRefused>().has_value()) << refused.error();
  const Frame before = robot_.tool().get().value();
  ASSERT_TRUE(robot_.mount("", translate(1, 0, 0)).get());
  EXPECT_TRUE(near(robot_.tool().get().value(), translate(1, 0, 0) * before, 1e-4, 1e-3));
}

}  // namespace
}  // namespace devices
