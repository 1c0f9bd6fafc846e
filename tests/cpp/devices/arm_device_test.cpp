#include "devices/arm/arm_device.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <vector>

#include "../robcl/allocations.hpp"
#include "../robcl/arms.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

using robcl::rx90;
using robcl::translate;
using namespace robcl::literals;

constexpr double cycle = 0.004;
const JointValues ready = robcl::joints({0, -20, 110, 0, 90, 0});

class Silent : public MotionWatcher {
 public:
  bool interrupted() override { return false; }
  void progress(double, double) override {}
};

/// Is the arm's control loop itself, and interrupts once a third of the motion's time is over.
class SteppingInterrupter : public MotionWatcher {
 public:
  explicit SteppingInterrupter(ArmDevice& arm) : arm_(arm) {}
  bool interrupted() override { return fraction_ > 1.0 / 3; }
  void progress(double fraction, double) override {
    fraction_ = fraction;
    for (int i = 0; i < 5; ++i) arm_.step(cycle);
  }

 private:
  ArmDevice& arm_;
  double fraction_ = 0;
};

/// Remembers what it was told.
class Listener : public MotionWatcher {
 public:
  bool interrupted() override { return false; }
  void progress(double fraction, double remaining) override {
    fractions.push_back(fraction);
    last_remaining = remaining;
  }
  std::vector<double> fractions;
  double last_remaining = -1;
};

class Arm : public ::testing::Test {
 protected:
  template <typename Ask>
  auto run(Ask ask) {
    auto answer = std::async(std::launch::async, ask);
    while (answer.wait_for(std::chrono::microseconds(200)) != std::future_status::ready) {
      arm_.step(cycle);
    }
    return answer.get();
  }

  const robcl::arm::ArmModel model_ = rx90();
  SimulatedDriver driver_{ready, {}};
  ArmDevice::Settings settings_{.tool_offset = translate(0, 0, 150_mm)};
  ArmDevice arm_{model_, settings_, driver_};
  Silent silent_;
};

TEST_F(Arm, StandsWithinATenthOfAMillimetreOfTheGoalWhenAMoveIsFinished) {
  const Frame goal = arm_.sample().tool * translate(0.05, 0.1, 0.1);
  for (const PathKind path : {PathKind::Straight, PathKind::Joint}) {
    const Frame there = path == PathKind::Straight ? goal : goal * translate(0, -0.1, 0);
    const auto moved = run([&] { return arm_.move(there, path, {}, silent_); });
    ASSERT_TRUE(moved.has_value()) << to_string(moved.error());
    EXPECT_LT(distance(arm_.sample().tool, there), 1e-4);
    EXPECT_FALSE(arm_.moving());
  }
}

TEST_F(Arm, GoalsAndReadingsAreInTheWorldWhereverItIsMounted) {
  const Frame base = Frame::from_euler_zyz(1, 2, 0.5, 90_deg, 0, 0);
  ASSERT_TRUE(arm_.mount(base).has_value());
  arm_.step(cycle);
  const Frame goal = base * Frame::from_euler_zyz(0.5, 0.2, 0.3, 0, 180_deg, 0);
  const auto moved = run([&] { return arm_.move(goal, PathKind::Joint, {}, silent_); });
  ASSERT_TRUE(moved.has_value()) << to_string(moved.error());
  EXPECT_TRUE(near(arm_.sample().tool, goal, 1e-4, 1e-3)) << arm_.sample().tool;
  EXPECT_TRUE(near(arm_.sample().flange * translate(0, 0, 150_mm), goal, 1e-4, 1e-3));
}

TEST(ArmBeyondALimit, ReturnsOnAStraightLine) {
  const robcl::arm::ArmModel model = rx90();
  JointValues beyond = robcl::joints({0, -20, 110, 0, 120, 0}), inside = beyond;
  beyond[4] += 2.4e-5;  // one count of an encoder beyond the limit of joint 5
  inside[4] = 100_deg;
  RecordingDriver driver(beyond);
  ArmDevice arm(model, {}, driver);
  Silent silent;
  const Frame goal = robcl::arm::Kinematics(model).base_from_flange(inside);
  auto moved = std::async(std::launch::async,
                          [&] { return arm.move(goal, PathKind::Straight, {}, silent); });
  while (moved.wait_for(std::chrono::microseconds(200)) != std::future_status::ready) {
    arm.step(cycle);
  }
  const auto end = moved.get();
  ASSERT_TRUE(end) << to_string(end.error());
  EXPECT_LT((driver.stands - inside).cwiseAbs().maxCoeff(), 1e-4);
  for (const JointValues& at : driver.all) ASSERT_LE(at[4], beyond[4] + 1e-9);
}

TEST_F(Arm, KeepsStandingWhereItStandsIfNobodyCommands) {
  const Frame before = arm_.sample().tool;
  for (int i = 0; i < 500; ++i) arm_.step(cycle);
  EXPECT_LT(distance(arm_.sample().tool, before), 1e-4);
}

TEST_F(Arm, AMotionThatIsInterruptedStandsOnItsPath) {
  const Frame start = arm_.sample().tool;
  const Frame goal = start * translate(0, 0.4, 0);
  SteppingInterrupter interrupter(arm_);
  const auto moved = arm_.move(goal, PathKind::Straight, {}, interrupter);
  ASSERT_FALSE(moved.has_value());
  EXPECT_TRUE(std::holds_alternative<Interrupted>(moved.error())) << to_string(moved.error());
  const Eigen::Vector3d seen = start.inverse().transform(arm_.sample().tool.position());
  EXPECT_GT(seen.y(), 0.1);
  EXPECT_LT(seen.y(), 0.39);
  EXPECT_NEAR(seen.x(), 0, 2e-4);
  EXPECT_NEAR(seen.z(), 0, 2e-4);
  const auto on = run([&] { return arm_.move(goal, PathKind::Straight, {}, silent_); });
  EXPECT_TRUE(on.has_value());
}

TEST_F(Arm, ProgressRisesToOneAndNothingRemains) {
  Listener listener;
  JointValues target = ready;
  target[0] += 1;
  const auto moved = run([&] { return arm_.move_joints(target, {}, listener); });
  ASSERT_TRUE(moved.has_value());
  EXPECT_TRUE(std::is_sorted(listener.fractions.begin(), listener.fractions.end()));
  EXPECT_EQ(listener.fractions.back(), 1);
  EXPECT_EQ(listener.last_remaining, 0);
  EXPECT_LT((arm_.sample().joints - target).cwiseAbs().maxCoeff(), 2e-4);
}

TEST_F(Arm, MountAndToolAreRefusedWhileItMoves) {
  class Announcer : public Silent {
   public:
    void progress(double, double) override {
      moving = true;
      moving.notify_all();
    }
    std::atomic<bool> moving{false};
  };
  Announcer announcer;
  auto mover = std::async(std::launch::async, [&] {
    return arm_.move(arm_.sample().tool * translate(0, 0.3, 0), PathKind::Straight, {}, announcer);
  });
  announcer.moving.wait(false);
  const auto mounted = arm_.mount(translate(1, 0, 0));
  const auto tool = arm_.set_tool_offset(Frame());
  while (mover.wait_for(std::chrono::microseconds(200)) != std::future_status::ready) {
    arm_.step(cycle);
  }
  ASSERT_FALSE(mounted.has_value());
  EXPECT_EQ(mounted.error().reason, "the arm is moving; mount it when it has stopped");
  ASSERT_FALSE(tool.has_value());
  EXPECT_TRUE(mover.get().has_value());
  EXPECT_TRUE(arm_.mount(translate(1, 0, 0)).has_value());
}

TEST_F(Arm, PlacesAtWhichCoordinatesHaveNoDigitsLeftAreRefused) {
  const Frame base = arm_.base(), offset = arm_.tool_offset();
  for (const double away : {2e7, 1e200, 1.7e308}) {
    const auto mounted = arm_.mount(translate(away, 0, -away));
    ASSERT_FALSE(mounted) << away;
    EXPECT_NE(mounted.error().reason.find("but it can be at most 1e+07 m away"), std::string::npos)
        << mounted.error().reason;
    const auto tool = arm_.set_tool_offset(translate(0, away, away));
    ASSERT_FALSE(tool) << away;
    EXPECT_NE(tool.error().reason.find("but it can be at most 1000 m away"), std::string::npos)
        << tool.error().reason;
  }
  EXPECT_EQ(arm_.base(), base);
  EXPECT_EQ(arm_.tool_offset(), offset);
  EXPECT_TRUE(arm_.mount(translate(5e6, 4e5, 0))) << "as in a grid of surveyors";
}

TEST_F(Arm, WhatCannotBeReachedFailsBeforeAnythingMoves) {
  const Frame before = arm_.sample().flange;
  const auto moved = arm_.move(translate(500, 0, 300), PathKind::Joint, {}, silent_);
  ASSERT_FALSE(moved.has_value());
  EXPECT_TRUE(std::holds_alternative<robcl::arm::OutOfReach>(moved.error()));
  robcl::motion::Pace pace;
  pace.speed = 2;
  const auto hasty = arm_.move(arm_.sample().tool, PathKind::Joint, pace, silent_);
  ASSERT_FALSE(hasty.has_value());
  EXPECT_EQ(to_string(hasty.error()), "speed is 2, but it must be above 0, at most 1");
  EXPECT_EQ(arm_.sample().flange, before);
}

TEST_F(Arm, ItsControlCycleAllocatesNothing) {
  robcl::motion::Planner planner(model_, {});
  ArmController controller(model_, {}, driver_);
  JointValues target = ready;
  target[1] += 0.5;
  controller.start(playing(planner.joints(controller.standing_at(), target, {}).value()));
  robcl::CountAllocations allocations;
  for (int i = 0; i < 500; ++i) controller.step(cycle);
  EXPECT_EQ(allocations.so_far(), 0);
  const auto outcome = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Arrived);
}

TEST(BrakingTime, IsThatOfAStopFromFullSpeedOrOfTheToolIfThatIsLonger) {
  const auto model = rx90();
  const robcl::motion::ToolLimits agile{.acceleration = 10, .turn_acceleration = 1440_deg};
  RecordingDriver driver(ready);
  const double told = ArmDevice(model, {.tool_limits = agile}, driver).braking_time();
  EXPECT_NEAR(ArmDevice(model, {}, driver).braking_time(), 1.0 / 3, 1e-9);  // 1 m/s, 3 m/s²
  const ArmDevice smooth(model, {.seconds_to_full_acceleration = 0.03}, driver);
  EXPECT_NEAR(smooth.braking_time(), 1.0 / 3 + 2 * 0.032, 1e-9);

  JointValues target = ready;
  target[0] += 2;
  ArmController controller(model, {}, driver);
  controller.start(playing(robcl::motion::Planner(model, {}).joints(ready, target, {}).value()));
  for (int i = 0; i < 90; ++i) controller.step(cycle);
  const auto& all = driver.all;
  ASSERT_NEAR(all.back()[0] - all[all.size() - 2][0], model.limits()[0].speed * cycle, 1e-6);
  controller.stop();
  int cycles = 0;
  do {
    controller.step(cycle);
    ++cycles;
  } while (all.back() != all[all.size() - 2]);
  EXPECT_LE(cycles * cycle, told + 2 * cycle);
  EXPECT_GE(cycles * cycle, told);
}

TEST_F(Arm, ProgressOfAMotionBeginsAtZeroAfterAnotherMotion) {
  JointValues target = ready;
  target[0] += 0.2;
  ASSERT_TRUE(run([&] { return arm_.move_joints(target, {}, silent_); }).has_value());
  Listener listener;
  auto mover =
      std::async(std::launch::async, [&] { return arm_.move_joints(ready, {}, listener); });
  while (mover.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    for (int k = 0; k < 10; ++k) arm_.step(cycle);
  }
  ASSERT_TRUE(mover.get().has_value());
  EXPECT_TRUE(std::is_sorted(listener.fractions.begin(), listener.fractions.end()));
  EXPECT_LT(listener.fractions.front(), 0.5);
}

TEST(BrokenArm, ThatDoesNotComeToItsGoalSaysWhichJoint) {
  const auto model = rx90();
  StandingDriver driver(ready);
  ArmController controller(model, {}, driver);
  robcl::motion::Planner planner(model, {});
  JointValues target = ready;
  target[2] -= 0.1;
  controller.start(playing(planner.joints(ready, target, {}).value()));
  for (int i = 0; i < 1000; ++i) controller.step(cycle);
  const auto outcome = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::NotSettled);
  EXPECT_EQ(outcome->axis, 2);
  EXPECT_NEAR(outcome->away, 0.1, 1e-9);
}

TEST(BrokenArm, WhoseDriverFailsEndsTheMotionWithItsWords) {
  const auto model = rx90();
  StandingDriver driver(ready);
  ArmController controller(model, {}, driver);
  robcl::motion::Planner planner(model, {});
  JointValues target = ready;
  target[2] -= 0.1;
  controller.start(playing(planner.joints(ready, target, {}).value()));
  for (int i = 0; i < 10; ++i) controller.step(cycle);
  driver.broken = true;
  controller.step(cycle);
  const auto outcome = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Fault);
  EXPECT_EQ(outcome->fault.text, "no answer from the drives");
  EXPECT_FALSE(controller.now().moving);
}

/// A motion whose third set point is not a number.
class UndefinedMotion : public robcl::motion::TrajectoryGenerator {
 public:
  const JointValues& start() const override { return ready; }
  JointValues advance(double) override {
    JointValues point = ready;
    point[1] += ++cycles_ < 3 ? 1e-3 * cycles_ : std::nan("");
    return point;
  }
  void set_override(double) override {}
  void stop() override {}
  void rest() override {}
  bool standing() const override { return false; }
  bool stopping() const override { return false; }
  double fraction() const override { return 0; }
  double remaining() const override { return 1; }

 private:
  int cycles_ = 0;
};

TEST(BrokenArm, WhoseMotionHasASetPointThatIsNoNumberStandsAndItsLoopGoesOn) {
  const auto model = rx90();
  RecordingDriver driver(ready);
  ArmController controller(model, {}, driver);
  controller.start(std::make_shared<UndefinedMotion>());
  for (int i = 0; i < 5; ++i) ASSERT_NO_THROW(controller.step(cycle));
  const auto outcome = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Fault);
  EXPECT_EQ(outcome->fault.text, "a set point of the motion is not finite; the arm stands");
  EXPECT_FALSE(controller.now().moving);
  ASSERT_EQ(driver.all.size(), 5U);
  for (std::size_t k = 2; k < 5; ++k) EXPECT_EQ(driver.all[k], driver.all[1]) << "it stands";
}

TEST(BrokenArm, WhoseMotionThrowsStandsAndItsLoopGoesOn) {
  class Throwing final : public UndefinedMotion {
   public:
    explicit Throwing(bool standard) : standard_(standard) {}
    JointValues advance(double) override {
      if (standard_) throw std::runtime_error("no such frame");
      throw 7;  // some exceptions of KDL do not derive from std::exception
    }

   private:
    const bool standard_;
  };
  const auto model = rx90();
  for (const bool standard : {true, false}) {
    RecordingDriver driver(ready);
    ArmController controller(model, {}, driver);
    controller.start(std::make_shared<Throwing>(standard));
    for (int i = 0; i < 5; ++i) ASSERT_NO_THROW(controller.step(cycle));
    const auto outcome = controller.wait(std::chrono::seconds(0));
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->fault.text, "the plan of the motion threw an exception; the arm stands");
    for (const JointValues& point : driver.all) EXPECT_EQ(point, ready);
  }
}

TEST(BrokenArm, StaysWhereItStandsWhenItsDriverIsBack) {
  const auto model = rx90();
  StandingDriver driver(ready);
  ArmController controller(model, {}, driver);
  driver.broken = true;
  controller.step(cycle);
  EXPECT_EQ(controller.standing_at(), ready) << "as measured last";
  driver.stands[1] += 0.2;  // it sank into its brakes
  driver.broken = false;
  controller.step(cycle);
  EXPECT_EQ(controller.standing_at(), driver.stands);
}

TEST(BrokenArm, WhoseDriverIsSilentKeepsTheStampOfWhatItSaidLast) {
  const auto model = rx90();
  StandingDriver driver(ready);
  ArmController controller(model, {}, driver);
  controller.step(cycle);
  const auto last = controller.now();
  driver.broken = true;
  for (int i = 0; i < 10; ++i) controller.step(cycle);
  EXPECT_EQ(controller.now().measured_at_ns, last.measured_at_ns);
  EXPECT_EQ(controller.now().cycle, last.cycle);
}

}  // namespace
}  // namespace devices
