// What the control loop expects of the drives, and how a motion ends that does not get it.
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "devices/arm/arm_device.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "driven_arm.hpp"

namespace devices {
namespace {

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

}  // namespace
}  // namespace devices
