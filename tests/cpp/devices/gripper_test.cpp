#include <thread>

#include "devices/gripper/gripper_servant.hpp"
#include "devices/world/gripper_watch.hpp"
#include "devices/world/world_servant.hpp"
#include "laboratory.hpp"
#include "robcl/gripper_client.hpp"
#include "robcl/world_client.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

/// A gripper that stands in the world, with a block of 60 mm between its fingers.
class GripperTest : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("WORLD", world_servant_);
    serve("GRIPPER", servant_);
    gripper_ = create<robcl::Gripper>("GRIPPER");
    in_world_ = create<robcl::World>("WORLD");
  }

  /// A cycle of the jaws, and of the world that watches them.
  auto cycle() {
    return [this] {
      servant_.step(0.005);
      servant_.publish();
      watch_.tick();
    };
  }
  using Names = std::vector<std::string>;
  Names holders_of_block() { return in_world_.find("block").get().value().holders; }

  SimulatedWorld world_{-1, {{"block", {translate(0, 0, 150_mm), {0.06, 0.06, 0.1}}, false, {}}}};
  GripperWatch watch_{lab_, world_, "GRIPPER"};
  WorldServant world_servant_{world_, [this] { watch_.carry(); }};
  GripperServant servant_{lab_, "GRIPPER", "WORLD", "", translate(0, 0, 150_mm), {}};
  robcl::Gripper gripper_;
  robcl::World in_world_;
};

TEST_F(GripperTest, ClosingHoldsWhatIsBetweenTheJawsAndEndsWhenTheWorldShowsIt) {
  const auto lease = gecos::actor(gripper_);
  ASSERT_TRUE(lease) << lease.error();
  ASSERT_TRUE(get(gripper_.open(100_mm), cycle()));
  const auto closed = get(gripper_.close(30), cycle());
  ASSERT_TRUE(closed) << closed.error();
  const auto jaws = gripper_.jaws().get().value();
  EXPECT_NEAR(jaws.width, 0.06, 1e-9);
  EXPECT_EQ(jaws.force, 30);
  EXPECT_EQ(jaws.held, "block");
  EXPECT_EQ(holders_of_block(), Names{"GRIPPER"});

  const auto opened = get(gripper_.open(100_mm), cycle());
  ASSERT_TRUE(opened) << opened.error();
  EXPECT_EQ(holders_of_block(), Names());
  EXPECT_FALSE(gripper_.jaws().get().value().holding);
}

/// A second gripper whose jaws are at the same block, from the other side.
class TwoGrippersTest : public GripperTest {
 protected:
  void SetUp() override {
    GripperTest::SetUp();
    serve("OTHER", other_servant_);
    other_ = create<robcl::Gripper>("OTHER");
  }
  void TearDown() override { stop_serving(); }

  auto both_cycle() {
    return [this] {
      cycle()();
      other_servant_.step(0.005);
      other_servant_.publish();
      other_watch_.tick();
    };
  }
  robcl::Frame block() { return in_world_.find("block").get().value().pose; }

  GripperWatch other_watch_{lab_, world_, "OTHER"};
  GripperServant other_servant_{lab_, "OTHER", "WORLD", "", translate(0, 0, 150_mm), {}};
  robcl::Gripper other_;
};

TEST_F(TwoGrippersTest, HandABlockOverAndBackAndItDoesNotMove) {
  const auto lease = gecos::actor(gripper_);
  const auto other_lease = gecos::actor(other_);
  ASSERT_TRUE(get(gripper_.open(100_mm), both_cycle()));
  ASSERT_TRUE(get(other_.open(100_mm), both_cycle()));
  ASSERT_TRUE(get(gripper_.close(30), both_cycle()));
  const robcl::Frame before = block();

  for (int i = 0; i < 2; ++i) {
    robcl::Gripper& from = i == 0 ? gripper_ : other_;
    robcl::Gripper& to = i == 0 ? other_ : gripper_;
    const Names one = i == 0 ? Names{"GRIPPER", "OTHER"} : Names{"OTHER", "GRIPPER"};
    const auto closed = get(to.close(30), both_cycle());
    ASSERT_TRUE(closed) << closed.error();
    EXPECT_EQ(holders_of_block(), one);
    const auto opened = get(from.open(100_mm), both_cycle());
    ASSERT_TRUE(opened) << opened.error();
    EXPECT_EQ(holders_of_block(), Names{one.back()});
    EXPECT_TRUE(near(block(), before, 1e-12, 1e-12));
  }

  ASSERT_TRUE(get(gripper_.open(100_mm), both_cycle()));
  EXPECT_EQ(holders_of_block(), Names());
  EXPECT_LT(block().z(), before.z() - 0.5) << "it falls to the floor, one metre below";
}

TEST_F(TwoGrippersTest, AGripperThatTheWorldDoesNotWatchSaysSo) {
  const auto lease = gecos::actor(gripper_);
  const auto other_lease = gecos::actor(other_);
  ASSERT_TRUE(get(gripper_.open(100_mm), both_cycle()));
  ASSERT_TRUE(get(other_.open(100_mm), both_cycle()));
  ASSERT_TRUE(get(gripper_.close(30), both_cycle()));
  const auto closed = get(other_.close(30), [this] {
    cycle()();
    other_servant_.step(0.005);
    other_servant_.publish();
  });
  ASSERT_FALSE(closed) << "that another gripper holds the block is no answer";
  EXPECT_NE(closed.error().text.find("'OTHER' holds the body 'block'"), std::string::npos)
      << closed.error().text;
}

TEST_F(GripperTest, RefusesAForceThatItDoesNotHaveWithItsLimitsInTheTextToo) {
  const auto lease = gecos::actor(gripper_);
  const auto refused = get(gripper_.close(1000), cycle());
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::ForceOutOfRange>();
  ASSERT_TRUE(why.has_value());
  EXPECT_EQ(why->upper, 100);
  EXPECT_EQ(refused.error().text, "ForceOutOfRange{value=1000 N, lower=0 N, upper=100 N}");
}

TEST_F(GripperTest, ThatIsStoppedStandsWithItsJawsWhereTheyAre) {
  const auto lease = gecos::actor(gripper_);
  const auto opening = gripper_.open(110_mm);
  while (gripper_.jaws().get().value().width < 70_mm) servant_.step(0.005);
  ASSERT_TRUE(gecos::stop(gripper_).get());
  const auto stopped = get(opening, [] {});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().detail, gecos::Detail::Stopped);
  while (gripper_.jaws().get().value().moving) std::this_thread::yield();  // its handler returns
  const double width = gripper_.jaws().get().value().width;
  EXPECT_LT(width, 110_mm);
  servant_.step(1);
  EXPECT_EQ(gripper_.jaws().get().value().width, width);
}

TEST_F(GripperTest, IsNotMountedOnAnArmThatIsNotThere) {
  const auto lease = gecos::actor(gripper_);
  const auto refused = get(gripper_.mount("NOBODY", robcl::Frame()), cycle());
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::MountRefused>();
  ASSERT_TRUE(why.has_value());
  EXPECT_NE(why->reason.find("no object is called NOBODY"), std::string::npos) << why->reason;
  EXPECT_EQ(gripper_.parent().get().value(), "");
}

}  // namespace
}  // namespace devices
