// Moves as the driver of an arm receives them, from a control loop of 1 ms and of 4 ms.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "../robcl/arms.hpp"
#include "../robcl/moving.hpp"
#include "../robcl/set_points.hpp"
#include "devices/arm/arm_controller.hpp"
#include "robcl/motion/planner.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

using robcl::motion::Plan;
using robcl::motion::Playback;
using Way = std::tuple<robcl::Moving, double, bool>;

/// The parameters are the arm, the period of the control loop in s, and whether the moves are
/// straight.
class DrivenMoves : public ::testing::TestWithParam<Way> {
 protected:
  /// Most straight lines between random joint positions leave the reach of the arm.
  Plan random_plan() {
    for (;;) {
      const JointValues from = random_(), to = random_();
      if (!straight_) return planner_.joints(from, to, {}).value();
      if (auto plan = planner_.straight(from, planner_.base_from_tool(to, {}), {}, {})) {
        return *std::move(plan);
      }
    }
  }
  void expect_on_path(const Plan& plan, const std::vector<JointValues>& all) {
    if (straight_) {
      const auto tools = robcl::motion::flanges_at(model_, all);
      const Frame from = planner_.base_from_tool(plan.start(), {});
      const Frame to = planner_.base_from_tool(plan.goal(), {});
      return robcl::motion::expect_on_line(tools, from.position(), to.position());
    }
    for (const JointValues& joints : all) {
      ASSERT_LT(robcl::motion::off_line(joints, plan.start(), plan.goal()), 1e-6);
    }
  }
  /// Checks that no joint moves further from one set point to the next one than it may in a cycle.
  void expect_steps_of_one_cycle(const std::vector<JointValues>& all) {
    for (std::size_t k = 1; k < all.size(); ++k) {
      for (Eigen::Index axis = 0; axis < model_.axes(); ++axis) {
        const double speed = std::abs(all[k][axis] - all[k - 1][axis]) / period_;
        ASSERT_LE(speed, model_.limits()[static_cast<std::size_t>(axis)].speed * 1.001)
            << "joint " << axis + 1 << " in cycle " << k;
      }
    }
  }
  /// Runs the control loop until the motion ends. Every .15 s on average, the loop misses 1 to 100
  /// cycles.
  std::optional<ArmController::Outcome> run_starved(ArmController& controller);

  const robcl::Moving arm_ = std::get<0>(GetParam());
  const int moves_ = arm_.rise > 0 ? 10 : 2;
  const double period_ = std::get<1>(GetParam());
  const bool straight_ = std::get<2>(GetParam());
  const robcl::arm::ArmModel model_ = arm_.model();
  robcl::motion::Planner planner_{model_, {}, robcl::motion::Smoothing::over(arm_.rise, period_)};
  robcl::RandomJoints random_{model_, 7};
  std::mt19937 engine_{7};
};

std::optional<ArmController::Outcome> DrivenMoves::run_starved(ArmController& controller) {
  std::bernoulli_distribution is_starved(period_ / 0.15);
  std::uniform_int_distribution<> missed_cycles(1, 100);
  std::optional<ArmController::Outcome> outcome;
  double fraction = 0;
  std::uint64_t missed = 0;
  for (int k = 0; !outcome && k * period_ < 200; ++k) {
    const int misses = is_starved(engine_) ? missed_cycles(engine_) : 0;
    missed += static_cast<std::uint64_t>(misses);
    controller.step((1 + misses) * period_);
    const auto now = controller.now();
    EXPECT_GE(now.fraction, fraction);
    EXPECT_EQ(now.missed, missed);
    if (HasFailure()) break;
    fraction = now.fraction;
    outcome = controller.wait(std::chrono::seconds(0));
  }
  return outcome;
}

TEST_P(DrivenMoves, ComeToTheDriverAsPlaybackMakesThem) {
  for (int move = 0; move < moves_; ++move) {
    const Plan plan = random_plan();
    RecordingDriver driver(plan.start(), period_);
    ArmController controller(model_, {}, driver);
    controller.start(playing(plan));
    Playback playback(plan);
    ASSERT_FALSE(playback.standing());
    while (!playback.standing()) {
      controller.step(period_);
      ASSERT_EQ(driver.all.back(), playback.advance(period_)) << "set point " << driver.all.size();
    }
    ASSERT_EQ(driver.all.back(), plan.goal());
  }
}

TEST_P(DrivenMoves, OfAStarvedLoopStayOnTheirPathInStepsOfOneCycleAndArrive) {
  for (int move = 0; move < moves_; ++move) {
    SCOPED_TRACE("move " + std::to_string(move));
    const Plan plan = random_plan();
    RecordingDriver driver(plan.start(), period_);
    driver.all.assign(1, plan.start());
    ArmController controller(model_, {}, driver);
    controller.start(playing(plan));
    const auto outcome = run_starved(controller);
    ASSERT_TRUE(outcome.has_value());
    ASSERT_EQ(outcome->end, ArmController::End::Arrived) << outcome->fault.text;
    ASSERT_EQ(driver.stands, plan.goal());
    ASSERT_NO_FATAL_FAILURE(expect_steps_of_one_cycle(driver.all));
    ASSERT_NO_FATAL_FAILURE(expect_on_path(plan, driver.all));
  }
}

std::string name_of(const ::testing::TestParamInfo<Way>& made) {
  const auto& [arm, period, straight] = made.param;
  return std::string(arm.name) + (period < 0.002 ? "_at_1_ms" : "_at_4_ms") +
         (straight ? "_straight" : "_joint");
}
INSTANTIATE_TEST_SUITE_P(Of, DrivenMoves,
                         ::testing::Combine(::testing::ValuesIn(robcl::all_moving),
                                            ::testing::Values(0.001, 0.004), ::testing::Bool()),
                         name_of);

}  // namespace
}  // namespace devices
