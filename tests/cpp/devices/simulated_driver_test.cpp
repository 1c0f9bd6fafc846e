// Drives that are simulated: lag, noise and brakes.
#include "devices/drivers/simulated_driver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "driven_arm.hpp"

namespace devices {
namespace {

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
