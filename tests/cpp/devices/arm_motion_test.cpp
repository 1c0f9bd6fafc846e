// Moves of several callers that an arm makes as one motion, in real time.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "../robcl/arms.hpp"
#include "../robcl/set_points.hpp"
#include "devices/arm/arm_device.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

using robcl::rx90;
using robcl::translate;
using namespace robcl::literals;
using namespace std::chrono_literals;

constexpr double cycle = 0.004;
const JointValues ready = robcl::joints({0, -20, 110, 0, 90, 0});

/// Joints that are where they were told to be. Remembers all set points.
class Recorder : public StandingDriver {
 public:
  using StandingDriver::StandingDriver;
  tl::expected<void, DriverFault> write(const JointCommand& command, double) override {
    if (fails) return tl::unexpected(DriverFault{"no answer from the drives"});
    stands = command.position;
    const std::lock_guard lock(mutex_);
    all_.push_back(stands);
    return {};
  }
  std::vector<JointValues> all() const {
    const std::lock_guard lock(mutex_);
    return all_;
  }
  std::atomic<bool> fails{false};

 private:
  mutable std::mutex mutex_;
  std::vector<JointValues> all_;
};

#ifdef __SANITIZE_THREAD__  // planning takes ten times as long
constexpr auto between_cycles = 40ms;
#else
constexpr auto between_cycles = 8ms;
#endif

/// Steps the arm, one cycle after the other. The arm's time passes half as fast as real time, and
/// more slowly on a busy machine, because planning takes real time on any machine.
class ControlLoop {
 public:
  template <class Arm>  // an ArmDevice or an ArmController
  explicit ControlLoop(Arm& arm)
      : thread_([&arm](std::stop_token stop) {
          while (!stop.stop_requested()) {
            arm.step(cycle);
            std::this_thread::sleep_for(between_cycles);
          }
        }) {}

 private:
  std::jthread thread_;
};

class Caller : public MotionWatcher {
 public:
  bool interrupted() override { return interrupt; }
  void progress(double its_fraction, double) override { fraction = its_fraction; }
  void taken() override {
    is_taken = true;
    is_taken.notify_all();
  }
  void passes_goal(double distance) override {
    corner = distance;
    corner.notify_all();
  }

  std::atomic<bool> interrupt{false}, is_taken{false};
  std::atomic<double> fraction{0}, corner{-1};
};

class Chain : public ::testing::Test {
 protected:
  using Result = tl::expected<void, MoveFailure>;

  /// Asks for a straight move that need not stop at its goal, as a caller of its own.
  std::future<Result> go_over(const Frame& goal, Caller& caller, double tool_speed = 0.25) {
    robcl::motion::Pace pace;
    pace.tool_speed = tool_speed;
    return std::async(std::launch::async, [=, this, &caller] {
      return arm_.move(goal, PathKind::Straight, pace, caller, std::nullopt, true);
    });
  }
  Frame beside(double y, double z = 0) const { return start_ * translate(0, y, z); }
  void expect_stands_at(const Frame& goal) {
    EXPECT_FALSE(arm_.moving());
    EXPECT_LT(distance(arm_.sample().tool, goal), 1e-6);
    ASSERT_NO_FATAL_FAILURE(robcl::motion::expect_within_limits(model_, driver_.all(), {}, cycle));
  }

  const robcl::arm::ArmModel model_ = rx90();
  Recorder driver_{ready};
  ArmDevice arm_{model_, {}, driver_};
  const Frame start_ = arm_.sample().tool;
  const ControlLoop loop_{arm_};
};

TEST_F(Chain, TheFirstMoveEndsWhileTheArmMovesOnAndTheCornerIsTold) {
  Caller one, other;
  auto first = go_over(beside(0.1), one);
  one.is_taken.wait(false);
  auto second = go_over(beside(0.1, -0.1), other);
  const auto passed = first.get();
  ASSERT_TRUE(passed) << to_string(passed.error());
  EXPECT_TRUE(arm_.moving());
  EXPECT_NEAR(one.corner, std::sqrt(2) * 0.25 * 0.25 / (8 * 3.0), 0.0005);  // |w - u|·v²/8a
  const auto arrived = second.get();
  ASSERT_TRUE(arrived) << to_string(arrived.error());
  EXPECT_EQ(other.corner, -1);
  EXPECT_EQ(other.fraction, 1);
  expect_stands_at(beside(0.1, -0.1));
}

TEST_F(Chain, AGoalThatIsRefusedLeavesTheMoveBeforeItAsItIs) {
  Caller one, other;
  auto first = go_over(beside(0.1), one);
  one.is_taken.wait(false);
  const auto refused = go_over(beside(5), other).get();
  ASSERT_FALSE(refused);
  EXPECT_TRUE(std::holds_alternative<robcl::arm::OutOfReach>(refused.error()));
  EXPECT_TRUE(first.get());
  expect_stands_at(beside(0.1));
}

TEST_F(Chain, AMoveThatComesTooLateBeginsWhenTheArmStands) {
  Caller one, other;
  auto first = go_over(beside(0.1), one);
  while (one.fraction < 0.9) std::this_thread::yield();
  auto second = go_over(beside(0.2), other);
  EXPECT_TRUE(first.get());
  EXPECT_EQ(one.corner, -1);
  EXPECT_TRUE(second.get());
  expect_stands_at(beside(0.2));
}

TEST_F(Chain, AMoveInPlaceBetweenOthersDoesNotStopThem) {
  Caller callers[3];
  auto first = go_over(beside(0.1), callers[0]);
  callers[0].is_taken.wait(false);
  auto in_place = go_over(beside(0.1), callers[1]);
  callers[1].is_taken.wait(false);
  auto last = go_over(beside(0.2), callers[2]);
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(in_place.get());
  EXPECT_TRUE(arm_.moving());
  EXPECT_TRUE(last.get());
  expect_stands_at(beside(0.2));
}

TEST_F(Chain, TheMovesOfOthersGoOnWhenOneIsInterrupted) {
  Caller callers[3];
  auto first = go_over(beside(0.1), callers[0]);
  callers[0].is_taken.wait(false);
  auto second = go_over(beside(0.1, -0.1), callers[1]);
  callers[1].is_taken.wait(false);
  auto third = go_over(beside(0, -0.1), callers[2]);
  callers[2].is_taken.wait(false);
  callers[1].interrupt = true;
  EXPECT_TRUE(first.get());
  const auto interrupted = second.get();
  ASSERT_FALSE(interrupted);
  EXPECT_TRUE(std::holds_alternative<Interrupted>(interrupted.error()));
  EXPECT_TRUE(third.get());
  expect_stands_at(beside(0, -0.1));
}

TEST_F(Chain, AMoveThatTheMotionDoesNotContainIsInterruptedWithoutAStop) {
  Caller one, late, after_it;
  robcl::motion::Pace gently;
  gently.acceleration = 0.05;  // brakes for .8 s
  auto first = std::async(std::launch::async, [&] {
    return arm_.move(beside(0.1), PathKind::Straight, gently, one, std::nullopt, true);
  });
  while (one.fraction < 0.7) std::this_thread::yield();
  auto second = go_over(beside(0), late);
  late.interrupt = true;
  EXPECT_TRUE(std::holds_alternative<Interrupted>(second.get().error()));
  EXPECT_TRUE(arm_.moving()) << "it would stand if it had stopped for the second move";
  auto third = go_over(beside(0.1, 0.05), after_it);
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(third.get());
  expect_stands_at(beside(0.1, 0.05));
}

TEST_F(Chain, MovesInPlaceAndMovesThatComeTogetherAreMadeInTheirOrder) {
  std::vector<std::unique_ptr<Caller>> callers;
  std::vector<std::future<Result>> moves;
  for (const double y : {0.0, 0.0, 0.05, 0.05, 0.002, 0.002, 0.05, 0.0}) {
    callers.push_back(std::make_unique<Caller>());
    moves.push_back(go_over(beside(y), *callers.back()));
    callers.back()->is_taken.wait(false);
  }
  for (auto& move : moves) {
    const auto ended = move.get();
    ASSERT_TRUE(ended) << to_string(ended.error());
  }
  expect_stands_at(start_);
}

TEST_F(Chain, AFaultOfTheDrivesEndsAllMoves) {
  Caller one, other;
  auto first = go_over(beside(0.1), one);
  one.is_taken.wait(false);
  auto second = go_over(beside(0.2), other);
  other.is_taken.wait(false);
  driver_.fails = true;
  for (auto* const move : {&first, &second}) {
    const auto ended = move->get();
    ASSERT_FALSE(ended);
    EXPECT_TRUE(std::holds_alternative<DriverFault>(ended.error())) << to_string(ended.error());
  }
  EXPECT_FALSE(arm_.moving());
}

TEST_F(Chain, WhoDoesNotGoOverKeepsTheArmForItself) {
  Caller one, other;
  auto first = std::async(std::launch::async,
                          [&] { return arm_.move(beside(0.1), PathKind::Straight, {}, one); });
  while (one.fraction == 0) std::this_thread::yield();
  EXPECT_FALSE(one.is_taken);
  const auto refused = go_over(beside(0.2), other).get();
  ASSERT_FALSE(refused);
  EXPECT_TRUE(std::holds_alternative<Refused>(refused.error()));
  EXPECT_TRUE(first.get());
}

TEST(ArmMotions, AMoveWhosePlanningThrowsIsRefusedAndTheNextOneGoesOn) {
  const auto model = rx90();
  Recorder driver(ready);
  ArmController controller(model, {}, driver);
  ArmMotion motion(controller, robcl::motion::Planner(model, {}));
  Caller caller;
  const ArmMotion::Request throws{
      [](auto&, const auto&) -> tl::expected<robcl::motion::Move, MoveFailure> {
        throw std::runtime_error("no memory for it");
      },
      true};
  for (int i = 0; i < 2; ++i) {
    const auto refused = motion.move(throws, caller);
    ASSERT_FALSE(refused);
    EXPECT_EQ(to_string(refused.error()), "the motion cannot be planned: no memory for it");
  }
  EXPECT_TRUE(motion.while_standing([] {}));
}

TEST(ArmMotions, AFollowWhoseBeginningThrowsLeavesTheArmToOthers) {
  const auto model = rx90();
  Recorder driver(ready);
  ArmController controller(model, {}, driver);
  ArmMotion motion(controller, robcl::motion::Planner(model, {}));
  Caller caller;
  const auto throws = [](const JointValues&) -> ArmMotion::Generator {
    throw std::runtime_error("no memory for it");
  };
  for (int i = 0; i < 2; ++i) {
    const auto refused = motion.alone(throws, caller);
    ASSERT_FALSE(refused);
    EXPECT_EQ(to_string(refused.error()), "the motion cannot be planned: no memory for it");
  }
  EXPECT_TRUE(motion.while_standing([] {}));
}

TEST(ArmMotions, AStopActsWhileTheNextMoveIsBeingMade) {
  const auto model = rx90();
  Recorder driver(ready);
  ArmController controller(model, {}, driver);
  ArmMotion motion(controller, robcl::motion::Planner(model, {}));
  JointValues there = ready;
  there[0] += 1;
  const auto to_there =
      [&](robcl::motion::Planner& planner,
          const JointValues& from) -> tl::expected<robcl::motion::Move, MoveFailure> {
    return *planner.joint_move(from, there, {.speed = 0.1});
  };
  const ControlLoop loop(controller);
  std::promise<void> making, made;
  Caller one, other;
  auto first = std::async(std::launch::async, [&] { return motion.move({to_there, true}, one); });
  one.is_taken.wait(false);
  while (!controller.now().moving) std::this_thread::yield();
  auto second = std::async(std::launch::async, [&] {
    return motion.move({[&](auto& planner, const auto& from) {
                          making.set_value();
                          made.get_future().wait();
                          return to_there(planner, from);
                        },
                        false},
                       other);
  });
  making.get_future().wait();
  one.interrupt = true;
  while (controller.now().moving) std::this_thread::yield();
  EXPECT_GT(there[0] - driver.all().back()[0], 0.1) << "it stopped on the way";
  other.interrupt = true;
  made.set_value();
  EXPECT_FALSE(first.get());
  EXPECT_FALSE(second.get());
}

TEST_F(Chain, HundredsOfMovesFollowWithoutAStop) {
  std::vector<std::unique_ptr<Caller>> callers;
  std::vector<std::future<Result>> moves;
  // A long move, during which the next ones are asked for, and then short ones.
  for (int i = 0; i <= 200; ++i) {
    const double along = i <= 100 ? i : 200 - i;
    callers.push_back(std::make_unique<Caller>());
    moves.push_back(go_over(beside(0.1 + 0.002 * along, -0.001 * i), *callers.back(), 0.25));
    callers.back()->is_taken.wait(false);
  }
  for (auto& move : moves) {
    const auto ended = move.get();
    ASSERT_TRUE(ended) << to_string(ended.error());
  }
  for (std::size_t i = 0; i + 1 < callers.size(); ++i) EXPECT_GE(callers[i]->corner, 0) << i;
  expect_stands_at(beside(0.1, -0.2));
}

/// Turns joint 1 by .3 rad, and asks for a turn by another .3 rad when .1 s is left, at a lab clock
/// of `clock_speed`. Returns whether the arm goes over into the second turn.
bool goes_over_late(double clock_speed) {
  const auto model = rx90();
  Recorder driver(ready);
  ArmController controller(model, {}, driver);
  ArmMotion motion(controller, robcl::motion::Planner(model, {}), clock_speed);
  std::atomic<int> made{0};
  const auto turn = [&](double angle) -> ArmMotion::Request {
    const auto make =
        [&made, angle](robcl::motion::Planner& planner,
                       const JointValues& from) -> tl::expected<robcl::motion::Move, MoveFailure> {
      JointValues there = ready;
      there[0] += angle;
      auto move = *planner.joint_move(from, there, {.speed = 0.1});
      ++made;
      made.notify_all();
      return move;
    };
    return {make, true};
  };
  Caller one, other;
  const auto begin = turn(0.3), go_on = turn(0.6);
  auto first = std::async(std::launch::async, [&] { return motion.move(begin, one); });
  one.is_taken.wait(false);
  do {
    controller.step(cycle);
  } while (controller.now().remaining > 0.1);
  auto second = std::async(std::launch::async, [&] { return motion.move(go_on, other); });
  made.wait(1);
  if (clock_speed == 1) one.corner.wait(-1);
  const ControlLoop loop(controller);
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(second.get());
  EXPECT_NEAR(driver.all().back()[0], ready[0] + 0.6, 1e-6);
  return one.corner >= 0;
}

class NamedCaller final : public Caller {
 public:
  explicit NamedCaller(std::uint64_t its_name) : name_(its_name) {}
  std::uint64_t caller() const override { return name_; }
  /// Called for all moves that have not ended, while one of them runs.
  bool interrupted() override {
    is_known = true;
    is_known.notify_all();
    return Caller::interrupted();
  }

  std::atomic<bool> is_known{false};

 private:
  const std::uint64_t name_;
};

/// Asks for a turn of joint 1, and so late for a second one of the caller 1 that the arm stands
/// before it. The second one is then impossible. Returns what becomes of a third one, of the caller
/// `last`, and expects that the arm stands `stands_at` beside its start.
ArmMotion::Result after_an_impossible_move(std::uint64_t last, double stands_at) {
  const auto model = rx90();
  Recorder driver(ready);
  ArmController controller(model, {}, driver);
  ArmMotion motion(controller, robcl::motion::Planner(model, {}));
  const auto to = [](double angle) {
    return [angle](robcl::motion::Planner& planner,
                   const JointValues& from) -> tl::expected<robcl::motion::Move, MoveFailure> {
      JointValues there = ready;
      there[0] += angle;
      return *planner.joint_move(from, there, {.speed = 0.1});
    };
  };
  int made = 0;
  const auto impossible_from_rest =
      [&](robcl::motion::Planner& planner,
          const JointValues& from) -> tl::expected<robcl::motion::Move, MoveFailure> {
    if (++made > 1) return tl::unexpected(robcl::arm::OutOfReach{"too far"});
    return to(0.4)(planner, from);
  };
  NamedCaller one(1), other(1), third(last);
  const auto asked = [&](const auto& make, Caller& caller) {
    return std::async(std::launch::async, [&motion, &caller, make] {
      return motion.move({make, true}, caller);
    });
  };
  auto first = asked(to(0.3), one);
  one.is_taken.wait(false);
  do {
    controller.step(cycle);
  } while (controller.now().remaining > 0.01);
  auto second = asked(impossible_from_rest, other);
  other.is_taken.wait(false);
  auto outcome = asked(to(0.2), third);
  third.is_known.wait(false);
  const ControlLoop loop(controller);
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(std::holds_alternative<robcl::arm::OutOfReach>(second.get().error()));
  auto result = outcome.get();
  EXPECT_NEAR(driver.all().back()[0], ready[0] + stands_at, 1e-6);
  return result;
}

TEST(ArmMotions, AMoveAfterAnImpossibleOneOfTheSameCallerIsNotBegun) {
  const auto left_out = after_an_impossible_move(1, 0.3);
  ASSERT_FALSE(left_out);
  EXPECT_EQ(to_string(left_out.error()),
            "the arm does not begin this move, because an earlier move failed: out of reach: too "
            "far");
}

TEST(ArmMotions, AMoveAfterAnImpossibleOneOfAnotherCallerIsMade) {
  EXPECT_TRUE(after_an_impossible_move(2, 0.2));
}

TEST(ArmMotions, AtAFastLabClockTheNextMoveMustComeSoonerBecausePlanningTakesRealTime) {
  EXPECT_TRUE(goes_over_late(1));
  EXPECT_FALSE(goes_over_late(20));
}

}  // namespace
}  // namespace devices
