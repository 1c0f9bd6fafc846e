// Sensor-guided motion from a client to the set points.
#include <deque>
#include <limits>

#include "../robcl/allocations.hpp"
#include "rx90_fixture.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

class FollowTest : public Rx90Laboratory {
 protected:
  using FollowCommand = gecos::Command<void, robcl::FollowState>;

  /// Begins to follow. Returns once the arm takes corrections: the first feedback tells so.
  FollowCommand follow(gecos::Writer<Frame>& alter,
                       robcl::FollowMode axes = robcl::FollowMode::IN_TOOL,
                       const robcl::FollowLimits& limits = {}) {
    auto following = robot_.follow(axes, limits);
    alter.feeds(following);
    while (!following.feedback() && following.state() == gecos::State::Running) {
      cycle()();
      // The watchdog counts cycles, so the feedback of each one gets 20 ms to arrive.
      for (int look = 0; look < 100 && !following.feedback(); ++look) {
        following.wait_for(std::chrono::microseconds(200));
      }
    }
    EXPECT_TRUE(following.feedback()) << following.get().error();
    return following;
  }
  /// Runs control cycles until the last feedback is `wanted`.
  template <class Wanted>
  void await(const FollowCommand& following, Wanted wanted) {
    while (following.wait_for(std::chrono::microseconds(200)) == gecos::State::Running) {
      cycle()();
      if (wanted(*following.feedback())) return;
    }
    ADD_FAILURE() << following.get().error();
  }
  gecos::Writer<Frame> writer() { return robot_.alter(gecos::writer).value(); }
};

TEST_F(FollowTest, FiveHundredCorrectionsAtOneKilohertzAddUp) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter);
  const Frame before = commanded_tool();
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(alter.send(translate(0, 0, -0.1_mm)));
    if (i % 4 == 3) cycle()();
  }
  // After this no correction comes: the arm stands at the sum, and the watchdog ends the command.
  const auto ended = get(following, cycle());
  ASSERT_FALSE(ended);
  const auto stopped = ended.error().as<robcl::CorrectionsStopped>();
  ASSERT_TRUE(stopped) << ended.error();
  EXPECT_EQ(stopped->state.applied, 500U);
  EXPECT_EQ(stopped->state.dropped, 0U);
  const auto report = alter.report().get().value();
  EXPECT_EQ(report.admitted, 500U);
  EXPECT_EQ(report.lost, 0U);
  EXPECT_TRUE(near(commanded_tool(), before * translate(0, 0, -50_mm), 1e-6, 1e-6));
  // The encoders of the simulated drives have a resolution of .024 mrad.
  EXPECT_LT(distance(robot_.tool().get().value(), commanded_tool()), 1e-4);
}

TEST_F(FollowTest, GoesOnUntilItIsCancelledAndThenStands) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter, robcl::FollowMode::IN_BASE);
  const Frame before = robot_.tool().get().value();
  ASSERT_TRUE(alter.send(translate(0, 20_mm, 0)));
  await(following, [&](const robcl::FollowState& state) {
    static_cast<void>(alter.send({}));  // so that the watchdog does not end it
    return state.applied > 0 && state.distance_left < 1e-9;
  });
  following.cancel();
  ASSERT_FALSE(get(following, cycle()));
  EXPECT_EQ(following.progress().detail, gecos::Detail::Canceled);
  const Frame moved(before.position() + Eigen::Vector3d(0, 20_mm, 0), before.orientation());
  EXPECT_LT(distance(robot_.tool().get().value(), moved), 1e-4);
}

TEST_F(FollowTest, DropsAndCountsCorrectionsBeyondTheLimitOfTheCaller) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter, robcl::FollowMode::IN_TOOL, {.distance = 5_mm});
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(alter.send(translate(0, 1_mm, 0)));
  await(following, [](const robcl::FollowState& state) { return state.dropped == 3; });
  EXPECT_EQ(following.feedback()->applied, 5U);
  following.cancel();
  EXPECT_FALSE(get(following, cycle()));
}

TEST_F(FollowTest, SaysThatItHoldsAtALimitAndComesBack) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter, robcl::FollowMode::IN_TOOL, {.distance = 3});
  ASSERT_TRUE(alter.send(translate(0, 0, -2)));  // m, up
  await(following, [&](const robcl::FollowState& state) {
    static_cast<void>(alter.send({}));
    return state.out_of_reach || state.limit_axis != 0;
  });
  ASSERT_TRUE(alter.send(translate(0, 0, 2)));
  await(following, [&](const robcl::FollowState& state) {
    static_cast<void>(alter.send({}));
    return !state.out_of_reach && state.limit_axis == 0 && state.distance_left < 1e-9;
  });
  following.cancel();
  EXPECT_FALSE(get(following, cycle()));
}

TEST_F(FollowTest, SamplesThatFeedNoFollowAreRefusedAndCounted) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  ASSERT_TRUE(alter.send(translate(0, 0, -10_mm)));
  cycle()();
  EXPECT_EQ(alter.report().get()->command_not_running, 1U);
  const auto following = follow(alter);
  alter.feeds_no_command();
  ASSERT_TRUE(alter.send(translate(0, 0, -10_mm)));
  const auto ended = get(following, cycle());
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().as<robcl::CorrectionsStopped>().value().state.applied, 0U);
  EXPECT_EQ(alter.report().get()->command_not_running, 2U);
}

TEST_F(FollowTest, ASampleThatIsNoFrameEndsTheCommandAsFault) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter);
  const JointValues before = arm_.sample().commanded;
  Frame no_frame;  // no constructor makes one
  const_cast<Eigen::Vector3d&>(no_frame.position()).x() = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(alter.send(no_frame));
  const auto ended = get(following, cycle());
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().detail, gecos::Detail::Fault) << ended.error();
  EXPECT_NE(ended.error().text.find("a sample of 'alter' is no correction"), std::string::npos)
      << ended.error();
  EXPECT_EQ(arm_.sample().commanded, before);
}

TEST_F(FollowTest, TheControlLoopAllocatesNothingWhileItTakesCorrections) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const auto commanded = robot_.commanded_joints(gecos::stream);
  const auto tool = robot_.tool(gecos::stream);
  ASSERT_TRUE(commanded && tool);
  auto alter = writer();
  for (int i = 0; i < 100; ++i) cycle()();  // fills the streams
  auto following = follow(alter);
  ASSERT_TRUE(alter.send({}));
  cycle()();  // the first sample gives the reader of the servant its buffer
  int allocations = 0;
  for (int i = 0; i < 400; ++i) {
    if (following.state() != gecos::State::Running) {
      following = follow(alter);  // this test got no processor for as long as the watchdog waits
    }
    ASSERT_TRUE(alter.send(translate(0, 0, i % 2 == 0 ? 0.1_mm : -0.1_mm)));
    const robcl::CountAllocations count;
    cycle()();
    allocations += count.so_far();
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GE(alter.report().get()->admitted, 300U);
  following.cancel();
  EXPECT_FALSE(get(following, cycle()));
}

TEST_F(FollowTest, AnotherFollowOrMoveWaitsItsTurnOrIsRefused) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  auto alter = writer();
  const auto following = follow(alter);
  const auto move = robot_.move(robot_.tool().get().value() * translate(0, 0, -10_mm));
  ASSERT_TRUE(alter.send(translate(0, 1_mm, 0)));
  EXPECT_FALSE(get(following, cycle()));
  ASSERT_TRUE(get(move, cycle())) << move.get().error();
}

}  // namespace
}  // namespace devices
