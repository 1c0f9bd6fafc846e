// A control loop that stood still goes on only if the drives held the joints meanwhile.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "../robcl/arms.hpp"
#include "devices/arm/arm_controller.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "robcl/motion/planner.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

using robcl::joints;
using robcl::rx90;

using End = ArmController::End;

constexpr double period = 0.004;  // s
constexpr double lag = 0.02;      // s at full speed by which a joint may lag behind
const JointValues begin_here = joints({0, -20, 110, 0, 90, 0});

/// Joints that follow exactly, until one of them slips.
class SlippingDriver : public StandingDriver {
 public:
  using StandingDriver::StandingDriver;
  tl::expected<void, DriverFault> write(const JointCommand& command, double) override {
    all.push_back(command.position);
    stands = command.position + slipped;
    return {};
  }
  std::vector<JointValues> all;
  JointValues slipped = JointValues::Zero(6);
};

class PausedLoop : public ::testing::Test {
 protected:
  /// Moves joint 1 by a radian, and lets the loop miss `missed` cycles in the middle of the motion.
  void stand_still_while_moving(int missed) {
    JointValues target = begin_here;
    target[0] += 1;
    controller_.start(playing(planner_.joints(begin_here, target, {}).value()));
    for (int i = 0; i < 60; ++i) controller_.step(period);
    const std::vector<JointValues>& all = driver_.all;
    ASSERT_GT(all.back()[0] - all[all.size() - 2][0], 0) << "it moves";
    held_ = all.back();
    driver_.slipped[1] = slips_;
    controller_.step((missed + 1) * period);
  }
  std::optional<ArmController::Outcome> outcome() {
    return controller_.wait(std::chrono::seconds(0));
  }

  const robcl::arm::ArmModel model_ = rx90();
  robcl::motion::Planner planner_{model_, {}};
  SlippingDriver driver_{begin_here};
  ArmController controller_{model_, {}, driver_};
  const double bound_ = lag * model_.limits()[1].speed;  // rad, of joint 2
  double slips_ = 0;
  JointValues held_;
};

TEST_F(PausedLoop, EndsItsMotionIfAJointMovedMeanwhile) {
  slips_ = -1.01 * bound_;
  stand_still_while_moving(ArmController::most_delayed + 1);
  const auto ended = outcome();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->end, End::Fault);
  EXPECT_EQ(
      ended->fault.text,
      "the control loop stood still, and joint 2 moved meanwhile: it is 4.0 deg away from its "
      "last set point, more than the 4.0 deg by which it may lag behind; look at the arm "
      "before it moves again");
  EXPECT_LT((driver_.all.back() - held_).cwiseAbs().maxCoeff(), 1e-3) << "it began from rest";
  EXPECT_EQ(controller_.standing_at(), driver_.stands) << "it stays where it was measured";
  const JointValues stood = driver_.stands;
  driver_.slipped.setZero();
  controller_.step(period);
  EXPECT_EQ(driver_.all.back(), stood);
}

TEST_F(PausedLoop, GoesOnFromTheLastSetPointIfTheJointsAreNearIt) {
  slips_ = 0.99 * bound_;
  stand_still_while_moving(100);
  EXPECT_FALSE(outcome());
  EXPECT_LT((driver_.all.back() - held_).cwiseAbs().maxCoeff(), 1e-3) << "from rest";
  std::optional<ArmController::Outcome> ended;
  for (int i = 0; i < 1000 && !ended; ++i) {
    driver_.slipped *= 0.9;  // a joint that came back at once would count as a wrong measurement
    controller_.step(period);
    ended = outcome();
  }
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->end, End::Arrived);
}

TEST_F(PausedLoop, ADelayOfAFewCyclesIsNotJudged) {
  slips_ = 2 * bound_;
  stand_still_while_moving(ArmController::most_delayed);
  EXPECT_FALSE(outcome());
}

TEST(PausedLoops, GoOnWithDrivesThatLagBehindAtFullSpeed) {
  const auto model = rx90();
  robcl::motion::Planner planner(model, {});
  JointValues target = begin_here;
  target[5] += 3;  // the fastest joint
  for (const double each : {0.001, 0.004}) {
    const auto every = static_cast<int>(0.16 / each);
    for (const int missed : {6, 20, 100}) {
      SimulatedDriver driver(begin_here, {.period = each});
      ArmController controller(model, {}, driver);
      controller.start(playing(planner.joints(controller.standing_at(), target, {}).value()));
      std::optional<ArmController::Outcome> ended;
      for (int i = 0; i < 3000 && !ended; ++i) {
        const bool stands_still = i % every == every - 1;
        controller.step(stands_still ? (missed + 1) * each : each);
        ended = controller.wait(std::chrono::seconds(0));
      }
      ASSERT_TRUE(ended) << missed << " cycles of " << each << " s";
      EXPECT_EQ(ended->end, End::Arrived) << ended->fault.text;
    }
  }
}

/// Joints that keep the commanded velocity until the next command.
class RunningOn : public StandingDriver {
 public:
  using StandingDriver::StandingDriver;
  Properties properties() const override { return {.mode = ControlMode::Velocity}; }
  tl::expected<void, DriverFault> write(const JointCommand& command, double since_last) override {
    stands += velocities.back() * (since_last - period) + command.velocity * period;
    velocities.push_back(command.velocity);
    return {};
  }

  std::vector<JointValues> velocities{JointValues::Zero(6)};
};

TEST(PausedLoops, ChangeTheVelocityOfDrivesThatRanOnWithinTheLimits) {
  const auto model = rx90();
  const robcl::arm::JointLimits& limits = model.limits()[0];
  for (int missed = 1; missed <= static_cast<int>(ArmController::most_delayed); ++missed) {
    RunningOn driver(begin_here);
    ArmController controller(model, {}, driver);
    JointValues target = begin_here;
    target[0] += 1;
    robcl::motion::Planner planner(model, {});
    controller.start(playing(planner.joints(begin_here, target, {}).value()));
    std::optional<ArmController::Outcome> ended;
    for (int i = 0; i < 1000 && !ended; ++i) {
      controller.step(i % 60 == 59 ? (missed + 1) * period : period);
      ended = controller.wait(std::chrono::seconds(0));
    }
    ASSERT_TRUE(ended) << missed;
    EXPECT_EQ(ended->end, End::Arrived) << ended->fault.text;
    for (std::size_t i = 1; i < driver.velocities.size(); ++i) {
      const double before = driver.velocities[i - 1][0], now = driver.velocities[i][0];
      ASSERT_LE(std::abs(now), limits.speed * 1.001) << missed;
      ASSERT_LE(std::abs(now - before), 2 * limits.acceleration * period * 1.001) << missed;
    }
  }
}

TEST(PausedLoops, DoNotRampDownAVelocityThatTheDrivesNoLongerHave) {
  /// Drives that stop by themselves when they get no command.
  class Stopping : public RunningOn {
   public:
    using RunningOn::RunningOn;
    tl::expected<void, DriverFault> write(const JointCommand& command, double) override {
      return RunningOn::write(command, period);
    }
  };
  const auto model = rx90();
  Stopping driver(begin_here);
  ArmController controller(model, {}, driver);
  JointValues target = begin_here;
  target[0] += 1;
  robcl::motion::Planner planner(model, {});
  controller.start(playing(planner.joints(begin_here, target, {}).value()));
  for (int i = 0; i < 60; ++i) controller.step(period);
  const double fast = driver.velocities.back()[0];
  controller.step(20 * period);
  EXPECT_LE(std::abs(driver.velocities.back()[0]),
            2 * model.limits()[0].acceleration * period * 1.001);
  EXPECT_GT(fast, 4 * model.limits()[0].acceleration * period) << "it was fast";
}

TEST(PausedLoops, EndTheMotionOfDrivesThatKeptTheirVelocity) {
  const auto model = rx90();
  RunningOn driver(begin_here);
  ArmController controller(model, {}, driver);
  JointValues target = begin_here;
  target[0] += 1;
  robcl::motion::Planner planner(model, {});
  controller.start(playing(planner.joints(begin_here, target, {}).value()));
  for (int i = 0; i < 60; ++i) controller.step(period);
  EXPECT_FALSE(controller.wait(std::chrono::seconds(0)));
  controller.step(20 * period);
  const auto ended = controller.wait(std::chrono::seconds(0));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->end, End::Fault);
  EXPECT_NE(ended->fault.text.find("joint 1 moved meanwhile"), std::string::npos)
      << ended->fault.text;
}

}  // namespace
}  // namespace devices
