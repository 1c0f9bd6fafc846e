// What the drives of an arm may do, and what becomes of a motion then.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <stdexcept>

#include "arms.hpp"
#include "devices/arm/arm_device.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

constexpr double beat = 0.004;
const JointValues start = robcl::joints({0, -20, 110, 0, 90, 0});

JointValues beside_start() {
  JointValues target = start;
  target[1] += 0.3;
  return target;
}

/// A plan from where the arm stands.
robcl::motion::Plan plan_of(const ArmController& controller) {
  robcl::motion::Planner planner(robcl::rx90(), {});
  return planner.joints(controller.standing_at(), beside_start(), {}).value();
}

/// How a motion away from `start` ends, `cycles` later at most; `meanwhile` once a cycle.
std::optional<ArmController::Outcome> outcome_of(
    ArmController& controller, const std::function<void(int)>& meanwhile = [](int) {}) {
  controller.start(playing(plan_of(controller)));
  for (int i = 0; i < 1000; ++i) {
    meanwhile(i);
    controller.step(beat);
    if (auto outcome = controller.wait(std::chrono::seconds(0))) return outcome;
  }
  return std::nullopt;
}

/// How a reset of the drives ends, 4000 cycles later at most; `meanwhile` before each cycle.
std::optional<ArmController::Outcome> reset(
    ArmController& controller, const std::function<void(int)>& meanwhile = [](int) {}) {
  controller.reset_drives();
  for (int i = 0; i < 4000; ++i) {
    meanwhile(i);
    controller.step(beat);
    if (auto outcome = controller.wait(std::chrono::seconds(0))) return outcome;
  }
  return std::nullopt;
}

/// Gives the answer that the test makes of the true one, after ten commands.
class LyingDriver : public StandingDriver {
 public:
  explicit LyingDriver(std::function<void(JointState&)> lie)
      : StandingDriver(start), lie_(std::move(lie)) {}
  tl::expected<void, DriverFault> write(const JointCommand&, double) override {
    ++commands_;
    return {};
  }
  tl::expected<JointState, DriverFault> read() override {
    JointState answer = state();
    if (commands_ >= 10) lie_(answer);
    return answer;
  }

 private:
  std::function<void(JointState&)> lie_;
  int commands_ = 0;
};

struct Lie {
  std::function<void(JointState&)> tell;
  std::string noticed;
};

TEST(LyingDriver, EndsTheMotionWithAFaultThatSaysWhyItCannotBeTrue) {
  const double none = std::nan("");
  for (const Lie& lie : std::vector<Lie>{
           {[&](JointState& state) { state.position[3] = none; }, "a joint position is not finite"},
           {[](JointState& state) { state.position.conservativeResize(5); },
            "the answer has 5 joint positions, but the arm has 6 joints"},
           {[&](JointState& state) { state.velocity = JointValues::Constant(6, none); },
            "the joint velocities are not 6 finite numbers"},
           {[](JointState& state) { state.measured_at_ns -= 60'000'000'000; },
            "the measurement is 60 s old"},
           {[](JointState& state) { state.measured_at_ns += 60'000'000'000; },
            "the time of the measurement is 60 s in the future"},
           {[](JointState& state) { state.position[2] += 0.5; },
            "joint 3 moved by 0.5 rad in 0.004 s; the joint can move by at most 0.02 rad in this "
            "time"}}) {
    LyingDriver driver(lie.tell);
    ArmController controller(robcl::rx90(), {}, driver);
    const auto outcome = outcome_of(controller);
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->end, ArmController::End::Fault);
    EXPECT_EQ(outcome->fault.text, "the driver's answer cannot be true: " + lie.noticed);
  }
}

TEST(ThrowingDriver, EndsTheMotionWithAFaultWhateverItThrows) {
  for (const auto& [throwing, text] :
       std::vector<std::pair<std::function<void(JointState&)>, std::string>>{
           {[](JointState&) { throw std::runtime_error("line cut"); },
            "the driver threw: line cut"},
           {[](JointState&) { throw 7; },
            "the driver threw an exception that is not a std::exception"}}) {
    LyingDriver driver(throwing);
    ArmController controller(robcl::rx90(), {}, driver);
    const auto outcome = outcome_of(controller);
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->end, ArmController::End::Fault);
    EXPECT_EQ(outcome->fault.text, text);
  }
}

TEST(DriverFault, IsKeptUntilTheDrivesAreResetAndTheArmThenMovesFromWhereItStands) {
  SimulatedDriver driver(start, {});
  ArmController controller(robcl::rx90(), {}, driver);
  const auto failed = outcome_of(controller, [&](int i) {
    if (i == 30) driver.break_down("overcurrent in axis 2");
  });
  ASSERT_TRUE(failed.has_value());
  EXPECT_EQ(failed->fault.text, "the drives have a fault: overcurrent in axis 2");
  const JointValues stood = driver.measured();
  EXPECT_EQ(controller.now().power, DrivePower::Fault);

  controller.start(playing(plan_of(controller)));
  controller.step(beat);
  const auto refused = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(refused.has_value()) << "nothing moves by itself";
  EXPECT_EQ(refused->fault.text, "the drives have a fault: overcurrent in axis 2");

  EXPECT_EQ(reset(controller)->end, ArmController::End::Arrived);
  EXPECT_EQ(controller.now().power, DrivePower::On);
  EXPECT_LT((driver.measured() - stood).cwiseAbs().maxCoeff(), 1e-3) << "it stands where it stood";
  controller.start(playing(plan_of(controller)));
  std::optional<ArmController::Outcome> moved;
  while (!moved) {
    controller.step(beat);
    moved = controller.wait(std::chrono::seconds(0));
  }
  EXPECT_EQ(moved->end, ArmController::End::Arrived) << moved->fault.text;
}

class SlowDrivesTest : public ::testing::Test {
 protected:
  void ends_as(const std::string& text) {
    const auto ended = reset(controller_);
    ASSERT_TRUE(ended.has_value());
    EXPECT_EQ(ended->end, ArmController::End::Fault);
    EXPECT_EQ(ended->fault.text, text);
  }

  SlowDrives driver_{start};
  ArmController controller_{robcl::rx90(), {}, driver_};
};

TEST_F(SlowDrivesTest, TheResetEndsWhenTheyAreOnAndTheirBrakesAreReleased) {
  driver_.brakes = Brakes::Engaged;
  const auto ended = reset(controller_, [&](int i) {
    if (i == 20) driver_.cycles_left = 1;
    if (i == 30) driver_.brakes = Brakes::Released;
    EXPECT_LE(i, 31);
    EXPECT_FALSE(controller_.now().moving);
    EXPECT_FALSE(i > 0 && i <= 20 && controller_.now().power == DrivePower::On);
  });
  ASSERT_TRUE(ended.has_value());
  EXPECT_EQ(ended->end, ArmController::End::Arrived) << ended->fault.text;
  EXPECT_EQ(driver_.power, DrivePower::On);
  EXPECT_EQ(driver_.brakes, Brakes::Released);
}

TEST_F(SlowDrivesTest, TheResetFailsWithTheWordsOfTheDriver) {
  driver_.kept = "axis 2 is still too hot";
  ends_as("axis 2 is still too hot");
  driver_.kept.clear();
  driver_.locked = "the emergency stop is pressed";
  ends_as("the emergency stop is pressed");
  driver_.locked.clear();
  const auto failed = reset(controller_, [&](int i) {
    if (i < 5) return;
    driver_.power = DrivePower::Fault;
    driver_.fault = "undervoltage";
  });
  ASSERT_TRUE(failed.has_value());
  EXPECT_EQ(failed->fault.text, "the drives have a fault: undervoltage");
  driver_.broken = true;
  ends_as("no answer from the drives");
}

TEST_F(SlowDrivesTest, TheResetFailsAfterTenSecondsIfTheyAreNotOn) {
  int cycles = 0;
  const auto failed = reset(controller_, [&](int i) { cycles = i + 1; });
  ASSERT_TRUE(failed.has_value());
  EXPECT_EQ(failed->fault.text, "the drives are turning on, 10 s after they were reset");
  EXPECT_NEAR(cycles * beat, 10, 2 * beat);
  driver_.cycles_left = 1;
  controller_.step(beat);
  const auto moved = outcome_of(controller_);
  ASSERT_TRUE(moved.has_value()) << "drives that turn on later may move the arm";
  EXPECT_NE(moved->end, ArmController::End::Fault) << moved->fault.text;
}

TEST_F(SlowDrivesTest, AStopBeforeTheNextCycleLeavesTheDrivesOff) {
  driver_.power = DrivePower::Off;
  controller_.reset_drives();
  controller_.stop();
  controller_.step(beat);
  const auto ended = controller_.wait(std::chrono::seconds(0));
  ASSERT_TRUE(ended.has_value());
  EXPECT_EQ(ended->end, ArmController::End::Stopped);
  EXPECT_EQ(driver_.resets, 0);
  EXPECT_EQ(driver_.power, DrivePower::Off);
}

TEST_F(SlowDrivesTest, AStopEndsTheWait) {
  const auto stopped = reset(controller_, [&](int i) {
    if (i == 5) controller_.stop();
    EXPECT_LE(i, 5);
  });
  ASSERT_TRUE(stopped.has_value());
  EXPECT_EQ(stopped->end, ArmController::End::Stopped);
}

/// Interrupts a call after some questions.
class Impatient : public MotionWatcher {
 public:
  explicit Impatient(int questions) : left_(questions) {}
  bool interrupted() override { return left_.fetch_sub(1) <= 0; }
  void progress(double, double) override {}

 private:
  std::atomic<int> left_;
};

TEST(ResetOfTheDrives, EndsWhenItsCallerInterruptsItAndIsRefusedMeanwhile) {
  SlowDrives driver(start);
  ArmDevice arm(robcl::rx90(), {}, driver);
  Impatient first(10), other(1000);
  auto waiting = std::async(std::launch::async, [&] { return arm.reset_drives(first); });
  while (driver.resets == 0) arm.step(beat);
  bool asked = false;
  while (waiting.wait_for(std::chrono::microseconds(100)) != std::future_status::ready) {
    arm.step(beat);
    if (std::exchange(asked, true)) continue;
    const auto refused = arm.reset_drives(other);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(std::holds_alternative<Refused>(refused.error())) << to_string(refused.error());
  }
  const auto ended = waiting.get();
  ASSERT_FALSE(ended);
  EXPECT_TRUE(std::holds_alternative<Interrupted>(ended.error())) << to_string(ended.error());
}

TEST(Drives, ThatDoNotSayWhenTheyMeasuredAreTakenToHaveMeasuredNow) {
  StandingDriver driver(start);
  driver.tells_time = false;
  ArmController controller(robcl::rx90(), {}, driver);
  for (int i = 0; i < 2; ++i) {
    const std::int64_t before = unix_ns();
    controller.step(beat);
    EXPECT_GE(controller.now().measured_at_ns, before);
    EXPECT_LE(controller.now().measured_at_ns, unix_ns());
  }
}

TEST(Drives, ThatAreNotReadyBeginNoMotion) {
  for (const auto& [power, brakes, text] : std::vector<std::tuple<DrivePower, Brakes, std::string>>{
           {DrivePower::Off, Brakes::Engaged, "the drives are off"},
           {DrivePower::TurningOn, Brakes::Engaged, "the drives are turning on"},
           {DrivePower::On, Brakes::Engaged, "the brakes of the drives are engaged"}}) {
    StandingDriver driver(start);
    driver.power = power;
    driver.brakes = brakes;
    ArmController controller(robcl::rx90(), {}, driver);
    const auto outcome = outcome_of(controller);
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->end, ArmController::End::Fault);
    EXPECT_EQ(outcome->fault.text, text);
  }
}

TEST(Drives, ThatCannotBeEnabledSayWhy) {
  class Locked : public StandingDriver {
   public:
    using StandingDriver::StandingDriver;
    tl::expected<void, DriverFault> enable() override {
      return tl::unexpected(DriverFault{"the emergency stop is pressed"});
    }
  };
  Locked driver(start);
  driver.power = DrivePower::Off;
  ArmController controller(robcl::rx90(), {}, driver);
  const auto outcome = outcome_of(controller);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->fault.text, "the emergency stop is pressed");
}

TEST(Drives, WhoseBrakesEngageOnTheWayEndTheMotion) {
  StandingDriver driver(start);
  ArmController controller(robcl::rx90(), {}, driver);
  const auto outcome = outcome_of(controller, [&](int i) {
    if (i == 5) driver.brakes = Brakes::Engaged;
  });
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->fault.text, "the brakes of the drives are engaged");
}

TEST(Drives, ThatFollowVelocityAloneComeToTheirGoalToo) {
  SimulatedDriver driver(start, {.mode = ControlMode::Velocity});
  ArmController controller(robcl::rx90(), {}, driver);
  const auto outcome = outcome_of(controller);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Arrived) << outcome->fault.text;
  EXPECT_LT((driver.measured() - beside_start()).cwiseAbs().maxCoeff(), 2e-4);
  for (int i = 0; i < 500; ++i) controller.step(beat);
  EXPECT_LT((driver.measured() - beside_start()).cwiseAbs().maxCoeff(), 2e-4) << "it stays there";
}

TEST(Drives, GiveThePeriodOfTheControlLoop) {
  SimulatedDriver driver(start, {.period = 0.001});
  ArmController controller(robcl::rx90(), {}, driver);
  controller.step(0.001);
  EXPECT_EQ(controller.now().missed, 0U);
  controller.step(0.004);
  EXPECT_EQ(controller.now().missed, 3U);

  const auto plan = plan_of(controller);
  controller.start(playing(plan));
  int cycles = 0;
  while (!controller.wait(std::chrono::seconds(0))) {
    controller.step(0.001);
    if (controller.now().fraction < 1) ++cycles;
  }
  EXPECT_NEAR(cycles * 0.001, plan.law.duration(), 0.002);
}

TEST(Drives, ThatDoNotFitTheArmAreRefusedWhenItIsMade) {
  SimulatedDriver standing_still(start, {.period = 0});
  EXPECT_THROW(ArmController(robcl::rx90(), {}, standing_still), std::invalid_argument);
  StandingDriver seven(JointValues::Zero(7));
  EXPECT_THROW(ArmController(robcl::rx90(), {}, seven), std::runtime_error);
}

TEST(Drives, ThatWereNotServedForLongerThanTheyAllowDoNotGoOn) {
  class Watchful : public StandingDriver {
   public:
    using StandingDriver::StandingDriver;
    Properties properties() const override { return {.longest_gap = 0.02}; }
  };
  Watchful driver(start);
  ArmController controller(robcl::rx90(), {}, driver);
  controller.start(playing(plan_of(controller)));
  for (int i = 0; i < 20; ++i) controller.step(beat);
  controller.step(0.5);
  const auto outcome = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Fault);
  EXPECT_EQ(outcome->fault.text.rfind("the control loop stalled for 0.5", 0), 0U)
      << outcome->fault.text;
}

/// Does not return from `write` while it is held.
class HeldDriver : public StandingDriver {
 public:
  using StandingDriver::StandingDriver;
  tl::expected<void, DriverFault> write(const JointCommand&, double) override {
    held.wait(true);
    return {};
  }
  std::atomic<bool> held{false};
};

TEST(DriverThatDoesNotReturn, EndsTheMoveAndNoOtherBeginsBeforeItDoes) {
  class Patient : public MotionWatcher {
   public:
    bool interrupted() override { return false; }
    void progress(double, double) override {}
  } watcher;
  HeldDriver driver(start);
  ArmDevice arm(robcl::rx90(), {}, driver);
  driver.held = true;
  auto loop = std::async(std::launch::async, [&] { arm.step(beat); });
  const auto failed = arm.move_joints(beside_start(), {}, watcher);
  ASSERT_FALSE(failed);
  EXPECT_EQ(to_string(failed.error()),
            "the control loop has stalled: a call of the driver does not return");
  const auto refused = arm.move_joints(beside_start(), {}, watcher);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(std::holds_alternative<DriverFault>(refused.error())) << to_string(refused.error());
  driver.held = false;
  driver.held.notify_all();
  loop.get();
}

/// The joints after a cycle with the command `goal`.
JointState after(const JointCommand& goal, SimulatedDriver& driver) {
  EXPECT_TRUE(driver.write(goal, beat));
  return driver.read().value();
}

TEST(SimulatedDriver, LagsBehindItsCommandAndComesToIt) {
  SimulatedDriver driver(JointValues::Zero(6), {});
  ASSERT_TRUE(driver.enable());
  const JointCommand goal{JointValues::Constant(6, 0.1), {}};
  const JointState first = after(goal, driver);
  EXPECT_NEAR(first.position[0], 0.1 * (1 - std::exp(-0.4)), 1e-4);
  for (int i = 0; i < 50; ++i) after(goal, driver);
  EXPECT_LT((driver.measured() - goal.position).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(SimulatedDriver, TheSameSeedGivesTheSameNoise) {
  SimulatedDriver one(start, {}), other(start, {});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(one.measured(), other.measured());
  SimulatedDriver differs(start, {.seed = 2});
  bool same = true;
  for (int i = 0; i < 10; ++i) same &= one.measured() == differs.measured();
  EXPECT_FALSE(same);
}

TEST(SimulatedDriver, StandsInItsBrakesUnlessItIsOn) {
  SimulatedDriver driver(start, {.noise = 0});
  const JointCommand goal{JointValues::Constant(6, 0.1), {}};
  const JointState before = after(goal, driver);
  EXPECT_EQ(before.power, DrivePower::Off);
  EXPECT_EQ(before.brakes, Brakes::Engaged);
  ASSERT_TRUE(driver.enable());
  EXPECT_NE(after(goal, driver).position, before.position);
  ASSERT_TRUE(driver.disable());
  const JointState stopped = after(goal, driver);
  EXPECT_EQ(after(goal, driver).position, stopped.position);
  driver.break_down("no supply");
  EXPECT_FALSE(driver.enable()) << "not before it is reset";
  EXPECT_EQ(after(goal, driver).fault, "no supply");
  ASSERT_TRUE(driver.reset());
  EXPECT_TRUE(driver.enable());
}

}  // namespace
}  // namespace devices
