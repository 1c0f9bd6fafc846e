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

robcl::motion::Plan plan_to(const robcl::arm::ArmModel& model, const JointValues& target) {
  return robcl::motion::Planner(model, {}).joints(start, target, {}).value();
}

/// How a motion away from `start` ends, `cycles` later at most; `meanwhile` once a cycle.
std::optional<ArmController::Outcome> outcome_of(
    ArmController& controller, const std::function<void(int)>& meanwhile = [](int) {}) {
  controller.start(playing(plan_to(robcl::rx90(), beside_start())));
  for (int i = 0; i < 1000; ++i) {
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

  controller.start(playing(robcl::motion::Planner(robcl::rx90(), {})
                               .joints(controller.standing_at(), beside_start(), {})
                               .value()));
  controller.step(beat);
  const auto refused = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(refused.has_value()) << "nothing moves by itself";
  EXPECT_EQ(refused->fault.text, "the drives have a fault: overcurrent in axis 2");

  controller.reset_drives();
  controller.step(beat);
  EXPECT_EQ(controller.now().power, DrivePower::On);
  EXPECT_LT((driver.measured() - stood).cwiseAbs().maxCoeff(), 1e-3) << "it stands where it stood";
  controller.start(playing(robcl::motion::Planner(robcl::rx90(), {})
                               .joints(controller.standing_at(), beside_start(), {})
                               .value()));
  std::optional<ArmController::Outcome> moved;
  while (!moved) {
    controller.step(beat);
    moved = controller.wait(std::chrono::seconds(0));
  }
  EXPECT_EQ(moved->end, ArmController::End::Arrived) << moved->fault.text;
}

TEST(DriverFault, AMotionThatIsRequestedAfterTheResetBeginsAfterIt) {
  SimulatedDriver driver(start, {});
  ArmController controller(robcl::rx90(), {}, driver);
  driver.break_down("overcurrent in axis 2");
  controller.step(beat);
  controller.reset_drives();
  const auto outcome = outcome_of(controller);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Arrived) << outcome->fault.text;
}

TEST(Drives, AreNotResetDuringAMotion) {
  class Counting : public StandingDriver {
   public:
    using StandingDriver::StandingDriver;
    tl::expected<void, DriverFault> write(const JointCommand& command, double) override {
      stands = command.position;
      return {};
    }
    tl::expected<void, DriverFault> reset() override {
      ++resets;
      return {};
    }
    int resets = 0;
  };
  Counting driver(start);
  ArmController controller(robcl::rx90(), {}, driver);
  const auto outcome = outcome_of(controller, [&](int i) {
    if (i == 5) controller.reset_drives();
    EXPECT_EQ(driver.resets, 0);
  });
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->end, ArmController::End::Arrived) << outcome->fault.text;
  controller.step(beat);
  EXPECT_EQ(driver.resets, 1);
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

  const auto plan = plan_to(robcl::rx90(), beside_start());
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
  controller.start(playing(plan_to(robcl::rx90(), beside_start())));
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
