#include "robcl/motion/following.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "allocations.hpp"
#include "arms.hpp"
#include "robcl/arm/inverse.hpp"
#include "set_points.hpp"

namespace robcl::motion {
namespace {

using arm::ArmModel;

/// Corrections that the test gives.
class Corrections : public CorrectionSource {
 public:
  std::optional<Frame> next() override {
    if (waiting.empty()) return std::nullopt;
    const Frame first = waiting.front();
    waiting.pop_front();
    return first;
  }
  bool expired() override { return stopped; }
  void report(const FollowState& state) override { last = state; }

  std::deque<Frame> waiting;
  bool stopped = false;
  FollowState last;
};

struct TestedArm {
  const char* name;
  ArmModel (*model)();
  JointValues from;  // in front of the arm, far from every singularity
};

const std::array arms{
    TestedArm{"Rx90", &rx90, joints({0, -20, 110, 0, 90, 0})},
    TestedArm{"Puma560", &puma560, joints({0, 45, -180, 0, -45, 0})},
    TestedArm{"SevenAxes", &seven_axes, joints({0, 30, 0, -75, 0, 75, 0})},
};

class Follow : public ::testing::TestWithParam<TestedArm> {
 protected:
  /// Makes the motion, which starts again at `from`.
  Following& start(CorrectionAxes axes, const FollowLimits& limits = {}) {
    corrections_ = std::make_shared<Corrections>();
    set_points_ = {from_, from_};  // it stood before
    return following_.emplace(model_, from_, tool_, axes, limits, corrections_);
  }
  /// Runs cycles of `period` seconds and keeps the set points.
  void run(long cycles, double period) {
    for (long i = 0; i < cycles; ++i) set_points_.push_back(following_->advance(period));
  }
  Frame tool_at(const JointValues& joints) { return forward_.base_from_flange(joints) * tool_; }
  Frame tool_now() { return tool_at(set_points_.back()); }
  Frame tool_before() { return tool_at(from_); }
  void guide_into_a_limit_and_back(const Frame& step, double period);
  void expect_within_limits(double period) {
    motion::expect_within_limits(model_, set_points_, {}, period);
  }

  const ArmModel model_ = GetParam().model();
  const JointValues from_ = GetParam().from;
  const Frame tool_ = translate(0, 0, 0.1) * rotate_x(0.3);
  arm::Kinematics forward_{model_};
  std::shared_ptr<Corrections> corrections_;
  std::optional<Following> following_;
  std::vector<JointValues> set_points_;
};
INSTANTIATE_TEST_SUITE_P(Of, Follow, ::testing::ValuesIn(arms),
                         [](const auto& arm) { return arm.param.name; });

TEST_P(Follow, FiveHundredCorrectionsAddUpExactly) {
  for (const double period : {0.001, 0.004}) {
    for (const auto& [x, y, z] : {std::array{1e-4, 0., 0.}, {0., 1e-4, 0.}, {0., 0., -1e-4}}) {
      start(CorrectionAxes::Tool);
      for (int sent = 0; sent < 500;) {  // 1 kHz
        for (int i = 0; i < std::lround(period / 0.001); ++i, ++sent) {
          corrections_->waiting.push_back(translate(x, y, z));
        }
        run(1, period);
      }
      run(std::lround(1 / period), period);
      EXPECT_TRUE(
          near(tool_now(), tool_before() * translate(500 * x, 500 * y, 500 * z), 1e-8, 1e-8))
          << tool_now() << " at a cycle of " << period;
      EXPECT_EQ(corrections_->last.applied, 500);
      EXPECT_EQ(corrections_->last.dropped, 0);
      EXPECT_LT(corrections_->last.distance_left, 1e-9);
      expect_within_limits(period);
    }
  }
}

TEST_P(Follow, EndsBesideALimitThatRoundingExceeds) {
  constexpr double period = 0.004;
  const Eigen::Index last = model_.axes() - 1;
  JointValues at_limit = from_;
  at_limit[last] = model_.limits()[static_cast<std::size_t>(last)].upper;
  corrections_ = std::make_shared<Corrections>();
  following_.emplace(model_, at_limit, Frame(), CorrectionAxes::Tool, FollowLimits{}, corrections_);
  for (const double turn : {5e-10, -5e-10}) {
    corrections_->waiting.push_back(rotate_z(turn));
    following_->advance(period);
  }
  corrections_->waiting.push_back(rotate_z(5e-10));
  run(1, period);
  following_->stop();
  run(100, period);
  EXPECT_TRUE(following_->standing());
}

TEST_P(Follow, DropsACorrectionThatNoNumberCanHold) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> angle(-3, 3);
  for (int round = 0; round < 50; ++round) {
    FollowLimits limits;
    limits.angle = 4;
    start(CorrectionAxes::Tool, limits);
    corrections_->waiting.push_back(rotate_z(angle(engine)) * rotate_y(angle(engine)));
    corrections_->waiting.push_back(translate(1.7e308, 1.7e308, 0));
    run(5, 0.004);
    EXPECT_EQ(corrections_->last.applied, 1);
    EXPECT_EQ(corrections_->last.dropped, 1);
    EXPECT_TRUE(set_points_.back().allFinite());
  }
}

TEST_P(Follow, CorrectionsOfOneCycleAreMultipliedInOrder) {
  const Frame first = translate(0.01, 0, 0) * rotate_z(0.1), second = translate(0, 0.02, 0);
  start(CorrectionAxes::Tool);
  corrections_->waiting = {first, second};
  run(300, 0.004);
  EXPECT_TRUE(near(tool_now(), tool_before() * first * second, 1e-9, 1e-9)) << tool_now();
}

TEST_P(Follow, CorrectionsAlongTheAxesOfTheBaseTurnAboutTheTool) {
  start(CorrectionAxes::Base);
  corrections_->waiting = {translate(0.01, 0, 0.02), rotate_z(0.2)};
  run(300, 0.004);
  const Frame before = tool_before();
  const Frame wanted(before.position() + Eigen::Vector3d(0.01, 0, 0.02),
                     rotate_z(0.2).orientation() * before.orientation());
  EXPECT_TRUE(near(tool_now(), wanted, 1e-9, 1e-9)) << tool_now();
}

TEST_P(Follow, ALargeCorrectionIsCarriedIntoTheNextCyclesWithinTheLimitsOfTheTool) {
  constexpr double period = 0.004;
  FollowLimits limits;
  limits.tool.speed = 0.1;
  start(CorrectionAxes::Tool, limits);
  corrections_->waiting = {translate(0, 0, -0.1)};
  run(1, period);
  EXPECT_NEAR(corrections_->last.distance_left, 0.1, 1e-3);
  run(350, period);
  EXPECT_TRUE(near(tool_now(), tool_before() * translate(0, 0, -0.1), 1e-9, 1e-9));
  expect_within_limits(period);
  for (std::size_t i = 2; i + 1 < set_points_.size(); ++i) {
    const Eigen::Vector3d before = tool_at(set_points_[i - 1]).position();
    const Eigen::Vector3d now = tool_at(set_points_[i]).position();
    const Eigen::Vector3d after = tool_at(set_points_[i + 1]).position();
    EXPECT_LE((now - before).norm() / period, 0.1 * slack);
    EXPECT_LE((after - 2 * now + before).norm() / (period * period), 3.0 * slack);
    EXPECT_LE((now - before).cross(tool_before().rotation().col(2)).norm(), 1e-9) << "straight";
  }
}

TEST_P(Follow, CorrectionsBeyondTheTotalLimitAreDroppedAndCounted) {
  FollowLimits limits;
  limits.distance = 0.01;
  limits.angle = 0.1;
  start(CorrectionAxes::Tool, limits);
  for (int i = 0; i < 15; ++i) corrections_->waiting.push_back(translate(0, 0.001, 0));
  corrections_->waiting.push_back(rotate_x(0.2));
  run(200, 0.004);
  EXPECT_EQ(corrections_->last.applied, 10);
  EXPECT_EQ(corrections_->last.dropped, 6);
  EXPECT_TRUE(near(tool_now(), tool_before() * translate(0, 0.01, 0), 1e-9, 1e-9));
}

TEST_P(Follow, StandsWhenNothingComesAndEndsWhenTheSourceExpires) {
  constexpr double period = 0.004;
  start(CorrectionAxes::Tool);
  for (int i = 0; i < 100; ++i) {
    corrections_->waiting.push_back(translate(0, 0, -0.0008));  // .2 m/s
    run(1, period);
  }
  run(100, period);
  const JointValues held = set_points_.back();
  run(100, period);
  EXPECT_EQ(set_points_.back(), held) << "no drift";
  EXPECT_FALSE(following_->standing()) << "it follows on";
  corrections_->stopped = true;
  run(2, period);
  EXPECT_TRUE(following_->standing());
  EXPECT_TRUE(following_->expired());
  expect_within_limits(period);
}

TEST_P(Follow, BrakesAtOnceWhenTheSourceExpires) {
  constexpr double period = 0.001;
  start(CorrectionAxes::Tool);
  corrections_->waiting = {translate(0, 0, -0.3)};
  run(200, period);
  corrections_->stopped = true;
  const double speed = distance(tool_at(set_points_.end()[-2]), tool_now()) / period;
  ASSERT_GT(speed, 0.3);
  const Frame here = tool_now();
  int cycles = 0;
  for (; !following_->standing() && cycles < 1000; ++cycles) run(1, period);
  // The joints of two of the arms allow less than the tool's acceleration.
  const double acceleration = ToolLimits{}.acceleration / 2;
  EXPECT_LE(cycles * period, speed / acceleration + 2 * period);
  EXPECT_LE(distance(here, tool_now()), speed * speed / (2 * acceleration) + 1e-3);
  run(1, period);
  expect_within_limits(period);
}

/// Guides the tool by 2 m in steps of `step`, and back, one in each cycle of `period` seconds.
void Follow::guide_into_a_limit_and_back(const Frame& step, double period) {
  const double speed = step.position().norm() / period;
  FollowLimits limits;
  limits.distance = 4;
  start(CorrectionAxes::Tool, limits);
  for (int i = 0; i < 2 / (speed * period); ++i) {
    corrections_->waiting.push_back(step);
    run(1, period);
  }
  run(std::lround(2 / period), period);
  EXPECT_TRUE(corrections_->last.hold.limit_axis != 0 || corrections_->last.hold.out_of_reach);
  EXPECT_GT(corrections_->last.distance_left, 0.1);
  const JointValues held = set_points_.back();
  run(100, period);
  EXPECT_LT((set_points_.back() - held).cwiseAbs().maxCoeff(), 1e-12) << "it holds";
  for (int i = 0; i < 2 / (speed * period); ++i) {
    corrections_->waiting.push_back(step.inverse());
    run(1, period);
  }
  run(std::lround(2 / period), period);
  EXPECT_EQ(corrections_->last.hold.limit_axis, 0);
  EXPECT_FALSE(corrections_->last.hold.out_of_reach);
  EXPECT_TRUE(near(tool_now(), tool_before(), 1e-6, 1e-6)) << tool_now();
  expect_within_limits(period);
  const Eigen::Vector3d along = (tool_before().rotation() * step.position()).normalized();
  for (const JointValues& joints : set_points_) {
    const Eigen::Vector3d way = tool_at(joints).position() - tool_before().position();
    ASSERT_LE(way.cross(along).norm(), 5e-5) << "on the line";
    ASSERT_LE(angle(tool_at(joints), tool_before()), 1e-3);
  }
}

TEST_P(Follow, HoldsBeforeALimitOrTheEndOfItsReachAndComesBack) {
  for (const double period : {0.001, 0.004}) {
    for (const double speed : {0.25, 0.5, 1.0}) {
      const double step = speed * period;
      for (const Frame& each :
           {translate(0, 0, step), translate(step, 0, 0), translate(-step, 0, 0),
            translate(0, step, 0), translate(0, 0, -step)}) {
        SCOPED_TRACE(to_string(each) + " in each cycle of " + std::to_string(period) + " s");
        ASSERT_NO_FATAL_FAILURE(guide_into_a_limit_and_back(each, period));
      }
    }
  }
}

/// Returns the state of an RX90 that starts at `from`, 4 s after 100 corrections by `step`.
FollowState after_corrections(const JointValues& from, const Frame& step) {
  const auto corrections = std::make_shared<Corrections>();
  Following following(rx90(), from, translate(0, 0, 0.15), CorrectionAxes::Tool, {}, corrections);
  corrections->waiting.assign(100, step);
  for (int i = 0; i < 1000; ++i) following.advance(0.004);
  return corrections->last;
}

TEST(FollowInASingularity, OfTheWristMovesInTheDirectionsThatAreLeftAndHoldsForTheOthers) {
  const JointValues wrist = joints({0, -90, 90, 0, 0, 0});
  for (const Frame& step : {translate(0.0005, 0, 0), translate(0, 0, -0.0005), rotate_y(0.002)}) {
    const FollowState state = after_corrections(wrist, step);
    EXPECT_LT(state.distance_left + state.angle_left, 1e-9) << step;
  }
  for (const Frame& step : {translate(0, 0.0005, 0), rotate_x(0.002)}) {
    EXPECT_TRUE(after_corrections(wrist, step).hold.out_of_reach) << step;
  }
}

TEST(FollowInASingularity, InReadyTurnsAboutTheToolsAxisAndHoldsForAllElse) {
  const JointValues in_ready = joints({0, 0, 0, 0, 0, 0});  // stretched straight up
  for (const Frame& step : {rotate_z(0.002), rotate_z(-0.002)}) {
    const FollowState state = after_corrections(in_ready, step);
    EXPECT_LT(state.distance_left + state.angle_left, 1e-9) << step;
    EXPECT_FALSE(state.hold.out_of_reach) << step;
  }
  for (const Frame& step :
       {translate(0.0005, 0, 0), translate(-0.0005, 0, 0), translate(0, 0.0005, 0),
        translate(0, 0, 0.0005), translate(0, 0, -0.0005), rotate_x(0.002), rotate_y(0.002)}) {
    const FollowState state = after_corrections(in_ready, step);
    EXPECT_TRUE(state.hold.out_of_reach) << step;
    EXPECT_NEAR(state.distance_left + state.angle_left,
                100 * (step.position().norm() + angle(step, {})), 1e-9)
        << step << " moves nothing";
  }
}

TEST_P(Follow, WildCorrectionsKeepAllLimitsOfTheJoints) {
  std::mt19937 engine(7);
  std::normal_distribution<double> away(0, 1);
  for (const double period : {0.001, 0.004}) {
    for (int round = 0; round < 20; ++round) {
      FollowLimits limits;
      limits.distance = 3;
      limits.angle = 3;
      start(round % 2 == 0 ? CorrectionAxes::Tool : CorrectionAxes::Base, limits);
      for (int i = 0; i < 1500; ++i) {
        if (i % 10 == 0) {
          corrections_->waiting.push_back(
              translate(0.05 * away(engine), 0.05 * away(engine), 0.05 * away(engine)) *
              rotate_x(0.2 * away(engine)) * rotate_y(0.2 * away(engine)));
        }
        run(1, period);
        if (i == 700) {  // the loop missed cycles
          following_->rest();
          motion::expect_within_limits(model_, set_points_, {}, period);
          set_points_ = {set_points_.back(), set_points_.back()};
        }
      }
      following_->stop();
      for (int i = 0; !following_->standing() && i < 4000; ++i) run(1, period);
      EXPECT_TRUE(following_->standing());
      run(2, period);
      expect_within_limits(period);
    }
  }
}

TEST_P(Follow, KeepsItsConfigurationAndTheTurnsOfItsJoints) {
  constexpr double period = 0.004;
  const auto inverse = arm::make_inverse(model_);
  start(CorrectionAxes::Tool);
  for (int i = 0; i < 2000; ++i) {
    const double at = i * 2 * std::numbers::pi / 1000;
    corrections_->waiting.push_back(translate(0.00014 * std::cos(at), 0.00014 * std::sin(at), 0));
    run(1, period);
    EXPECT_LT((set_points_.end()[-1] - set_points_.end()[-2]).cwiseAbs().maxCoeff(), 0.01);
  }
  run(200, period);
  EXPECT_EQ(inverse->configuration(set_points_.back()), inverse->configuration(from_));
  EXPECT_TRUE(near(tool_now(), tool_before(), 1e-6, 1e-6)) << tool_now();
}

TEST_P(Follow, AllocatesNothing) {
  start(CorrectionAxes::Tool);
  corrections_->waiting = {translate(0, 0, 0.1), rotate_x(0.1), translate(0, 1, 0)};
  following_->advance(0.004);
  corrections_->waiting.clear();
  const CountAllocations count;
  for (int i = 0; i < 500; ++i) following_->advance(0.004);
  following_->rest();
  following_->stop();
  for (int i = 0; i < 100; ++i) following_->advance(0.004);
  EXPECT_EQ(count.so_far(), 0);
  EXPECT_TRUE(following_->standing());
}

}  // namespace
}  // namespace robcl::motion
