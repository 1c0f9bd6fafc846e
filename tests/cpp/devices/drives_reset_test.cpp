// Faults of the drives, and how a reset clears them.
#include <gtest/gtest.h>

#include <future>
#include <string>

#include "devices/arm/arm_device.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "driven_arm.hpp"

namespace devices {
namespace {

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
  EXPECT_EQ(failed->fault.text,
            "10 s after the reset, the drives are not ready: the drives are turning on");
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

}  // namespace
}  // namespace devices
