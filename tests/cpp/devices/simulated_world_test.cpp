#include "devices/world/simulated_world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "devices/gripper/simulated_gripper.hpp"
#include "devices/laser_distance_sensor/simulated_beam.hpp"

namespace devices {
namespace {

using robcl::rotate_x;
using robcl::rotate_y;
using robcl::rotate_z;
using robcl::translate;
using namespace robcl::literals;

TEST(RayHit, MeetsTheNearFaceOfATurnedBox) {
  const Box box{translate(1, 0, 0) * rotate_z(45_deg), {0.2, 0.2, 0.2}};
  const Frame along_x = rotate_y(90_deg);
  EXPECT_NEAR(ray_hit(along_x, 5, box).value(), 1 - 0.1 * std::sqrt(2.0), 1e-12);
  EXPECT_FALSE(ray_hit(along_x, 0.8, box).has_value());
  EXPECT_FALSE(ray_hit(rotate_y(-90_deg), 5, box).has_value());
  EXPECT_FALSE(ray_hit(translate(0, 0.15, 0) * along_x, 5, box).has_value());
  EXPECT_EQ(ray_hit(translate(1, 0, 0), 5, box), 0.0);
}

TEST(BetweenJaws, IsTheThicknessOfWhatThePadsMeet) {
  const Eigen::Vector2d pad(0.02, 0.02);
  const Frame down = translate(0.5, 0.2, 0.05) * rotate_y(180_deg);
  const Box block{translate(0.5, 0.2, 0.05), {0.06, 0.06, 0.1}};
  const Between straight = between_jaws(down, pad, 0.1, block).value();
  EXPECT_NEAR(straight.upper - straight.lower, 0.06, 1e-12);

  // Turned by a: the pads meet a rhombus of thickness 0.06 / cos a + 0.02 tan a.
  const Box turned{block.pose * rotate_z(10_deg), block.size};
  const Between slanted = between_jaws(down, pad, 0.1, turned).value();
  EXPECT_NEAR(slanted.upper - slanted.lower, 0.06 / std::cos(10_deg) + 0.02 * std::tan(10_deg),
              1e-12);

  EXPECT_FALSE(between_jaws(translate(0, 0, 0.1) * down, pad, 0.1, block).has_value());
  const Between filled = between_jaws(down, pad, 0.04, block).value();
  EXPECT_NEAR(filled.upper - filled.lower, 0.04, 1e-12);
}

TEST(FallOnto, StopsWhereCornersFacesOrEdgesMeet) {
  const Box table{translate(0, 0, -0.1), {1, 1, 0.2}};
  const Eigen::Vector3d cube(0.1, 0.1, 0.1);
  EXPECT_NEAR(fall_onto({translate(0, 0, 0.5), cube}, table).value(), 0.45, 1e-12);
  EXPECT_FALSE(fall_onto({translate(0, 2, 0.5), cube}, table).has_value());
  EXPECT_FALSE(fall_onto({translate(0, 0, -0.5), cube}, table).has_value());
  // Standing on an edge.
  EXPECT_NEAR(fall_onto({translate(0, 0, 0.5) * rotate_x(45_deg), cube}, table).value(),
              0.5 - 0.05 * std::sqrt(2.0), 1e-12);
  // Edge across edge, no corner over the other.
  const Box bar{translate(0, 0, 0) * rotate_x(45_deg), {1, 0.1, 0.1}};
  const Box across{translate(0, 0, 0.5) * rotate_z(90_deg) * rotate_x(45_deg), {1, 0.1, 0.1}};
  EXPECT_NEAR(fall_onto(across, bar).value(), 0.5 - 0.1 * std::sqrt(2.0), 1e-12);
  // Resting, also a little sunk in.
  EXPECT_EQ(fall_onto({translate(0, 0, 0.05), cube}, table), 0.0);
  EXPECT_EQ(fall_onto({translate(0, 0, 0.0499), cube}, table), 0.0);
}

class DemoWorld : public ::testing::Test {
 protected:
  SimulatedWorld world_{demo_floor(), demo_bodies()};
  const Frame grip_ = Frame::from_euler_zyz(0.5, 0.2, 0.05, 0, 180_deg, 0);
  using Names = std::vector<std::string>;
  Frame block() { return world_.find("BLOCK")->box.pose; }
  Names holders(const std::string& body) { return world_.find(body)->holders; }
};

TEST_F(DemoWorld, AHeldBodyFollowsItsCarrierExactly) {
  const Frame before = block();
  const Frame carrier = grip_ * translate(0, 0, -0.15);
  world_.track("GRIPPER", "BLOCK", carrier);
  EXPECT_EQ(holders("BLOCK"), Names{"GRIPPER"});
  const Frame lifted = carrier * translate(0, 0, -0.2) * rotate_z(30_deg);
  world_.track("GRIPPER", "BLOCK", lifted);
  EXPECT_TRUE(near(block(), lifted * carrier.inverse() * before, 1e-12, 1e-12));
  EXPECT_NEAR(block().z() - before.z(), 0.2, 1e-12);
}

TEST_F(DemoWorld, ABodyThatIsLetGoFallsToItsSupportAndKeepsItsOrientation) {
  const Frame carrier = grip_ * translate(0, 0, -0.15);
  world_.track("GRIPPER", "BLOCK", carrier);
  world_.track("GRIPPER", "BLOCK", translate(0.1, 0, 0.2) * rotate_z(20_deg) * carrier);
  const Frame held = block();
  world_.track("GRIPPER", "", carrier);
  EXPECT_EQ(holders("BLOCK"), Names());
  EXPECT_NEAR(block().z(), 0.05, 1e-12);
  EXPECT_NEAR(block().x(), held.x(), 1e-12);
  EXPECT_NEAR(angle(block(), held), 0, 1e-12);
}

TEST_F(DemoWorld, BesideTheTableItFallsToTheFloor) {
  world_.track("GRIPPER", "BLOCK", Frame());
  world_.track("GRIPPER", "BLOCK", translate(2, 0, 0.5));
  world_.track("GRIPPER", "", Frame());
  EXPECT_NEAR(block().z(), -0.70, 1e-12);
}

TEST_F(DemoWorld, AFixedBodyIsNotTaken) {
  world_.track("GRIPPER", "TABLE", Frame());
  EXPECT_EQ(holders("TABLE"), Names());
}

TEST_F(DemoWorld, OfTwoGrippersThatHoldABodyTheOneThatRemainsKeepsIt) {
  const Frame carrier = grip_ * translate(0, 0, -0.15);
  const Frame other = rotate_x(1) * translate(1, 1, 1);
  const Frame up = translate(0, 0, 0.4);
  for (const bool first_lets_go : {true, false}) {
    SCOPED_TRACE(first_lets_go);
    world_.track("GRIPPER", "BLOCK", carrier);
    world_.track("GRIPPER", "BLOCK", up * carrier);
    const Frame held = block();
    world_.track("OTHER", "BLOCK", other);
    EXPECT_EQ(holders("BLOCK"), (Names{"GRIPPER", "OTHER"}));
    EXPECT_TRUE(near(block(), held, 1e-12, 1e-12));

    const std::string gone = first_lets_go ? "GRIPPER" : "OTHER";
    const std::string remains = first_lets_go ? "OTHER" : "GRIPPER";
    world_.track(gone, "", Frame());
    EXPECT_EQ(holders("BLOCK"), Names{remains});
    EXPECT_TRUE(near(block(), held, 1e-12, 1e-12));

    const Frame at = first_lets_go ? other : up * carrier;
    world_.track(remains, "BLOCK", translate(0, 0.1, 0) * at);
    EXPECT_TRUE(near(block(), translate(0, 0.1, 0) * held, 1e-12, 1e-12));
    world_.track(remains, "", Frame());
    EXPECT_EQ(holders("BLOCK"), Names());
    EXPECT_NEAR(block().z(), 0.05, 1e-12);
    ASSERT_TRUE(world_.place("BLOCK", translate(0.5, 0.2, 0.05)).has_value());
  }
}

TEST_F(DemoWorld, TheGripperThatTookHoldLastCarriesTheBodyThroughTheJawsOfTheOther) {
  world_.track("GRIPPER", "BLOCK", Frame());
  world_.track("OTHER", "BLOCK", Frame());
  const Frame before = block();
  world_.track("GRIPPER", "BLOCK", translate(0.3, 0, 0));
  EXPECT_TRUE(near(block(), before, 1e-12, 1e-12));
  world_.track("OTHER", "BLOCK", translate(0, 0, 0.3));
  EXPECT_TRUE(near(block(), translate(0, 0, 0.3) * before, 1e-12, 1e-12));

  // The first gripper has seen the body move, so nothing jumps when it carries the body alone.
  world_.track("GRIPPER", "BLOCK", translate(0.3, 0, 0));
  world_.track("OTHER", "", Frame());
  world_.track("GRIPPER", "BLOCK", translate(0.3, 0, 0));
  EXPECT_TRUE(near(block(), translate(0, 0, 0.3) * before, 1e-12, 1e-12));
}

TEST_F(DemoWorld, ABodyNeverJumpsWhenGrippersTakeHoldAndLetGoInAnyOrder) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> length(-1, 1);
  const Names names = {"A", "B", "C"};
  std::vector<Frame> carriers(names.size());
  std::vector<bool> holding(names.size(), false);
  for (Frame& at : carriers) at = translate(length(random), length(random), length(random));
  for (int i = 0; i < 2000; ++i) {
    const std::size_t one = random() % names.size();
    const Names others = holders("BLOCK");
    const Frame before = block();
    holding[one] = !holding[one];
    world_.track(names[one], holding[one] ? "BLOCK" : "", carriers[one]);
    const bool falls = !holding[one] && others.size() == 1;
    EXPECT_EQ(holders("BLOCK").size(), holding[one] ? others.size() + 1 : others.size() - 1);
    EXPECT_TRUE(falls || near(block(), before, 1e-12, 1e-12)) << i;

    // The arm of the gripper that carries the body moves, then the world looks at all of them.
    const Names now = holders("BLOCK");
    if (now.empty()) continue;
    const auto last = std::find(names.begin(), names.end(), now.back()) - names.begin();
    const Frame step = translate(0.01 * length(random), 0, 0.01) * rotate_z(0.1 * length(random));
    const Frame here = block(), from = carriers[static_cast<std::size_t>(last)];
    carriers[static_cast<std::size_t>(last)] = from * step;
    world_.track(now.back(), "BLOCK", from * step);
    EXPECT_TRUE(near(block(), from * step * from.inverse() * here, 1e-12, 1e-12)) << i;
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (holding[k]) world_.track(names[k], "BLOCK", carriers[k]);
    }
  }
}

TEST_F(DemoWorld, TheBeamMeetsTheFirstBody) {
  const Frame down = translate(0.5, 0.2, 1) * rotate_y(180_deg);
  const auto hit = world_.cast(down, 2);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->body, "BLOCK");
  EXPECT_NEAR(hit->range, 0.9, 1e-12);
  EXPECT_FALSE(world_.cast(down, 0.5).has_value());
}

TEST_F(DemoWorld, JawsMeetTheBlockAtItsWidthAndNothingBesideIt) {
  const auto contact = world_.between(grip_, 0.1);
  ASSERT_TRUE(contact.has_value());
  EXPECT_EQ(contact->body, "BLOCK");
  EXPECT_NEAR(contact->width, 0.06, 1e-12);
  EXPECT_FALSE(world_.between(grip_ * translate(0, 0, -0.2), 0.1).has_value());
}

TEST_F(DemoWorld, PlacingIsRefusedForWhatIsUnknownHeldOrFixed) {
  using Problem = SimulatedWorld::PlaceProblem;
  EXPECT_EQ(world_.place("BOX", Frame()).error(), Problem::Unknown);
  EXPECT_EQ(world_.place("TABLE", Frame()).error(), Problem::Fixed);
  world_.track("GRIPPER", "BLOCK", Frame());
  EXPECT_EQ(world_.place("BLOCK", Frame()).error(), Problem::Held);
  world_.track("GRIPPER", "", Frame());
  EXPECT_TRUE(world_.place("BLOCK", translate(0.4, 0, 0.3)).has_value());
  EXPECT_EQ(block(), translate(0.4, 0, 0.3));
}

class Gripper : public ::testing::Test {
 protected:
  void settle() {
    for (int i = 0; i < 1000 && gripper_.state().moving; ++i) gripper_.step(0.01);
  }
  SimulatedGripper gripper_{{.max_width = 0.11, .max_force = 100, .speed = 0.1}};
};

TEST_F(Gripper, ClosesUntilItMeetsTheBodyAndPressesIt) {
  ASSERT_TRUE(gripper_.open(0.1, {}).has_value());
  settle();
  ASSERT_TRUE(gripper_.close(30, SimulatedGripper::Contact{0.06, "BLOCK"}).has_value());
  EXPECT_TRUE(gripper_.state().moving);
  gripper_.step(0.1);
  EXPECT_NEAR(gripper_.state().width, 0.09, 1e-12);
  EXPECT_FALSE(gripper_.state().holding);
  settle();
  const auto state = gripper_.state();
  EXPECT_TRUE(state.holding);
  EXPECT_EQ(state.held, "BLOCK");
  EXPECT_EQ(state.force, 30);
  EXPECT_NEAR(state.width, 0.06, 1e-12);
}

TEST_F(Gripper, ClosesOnNothingUntilTheJawsMeet) {
  ASSERT_TRUE(gripper_.close(30, {}).has_value());
  settle();
  EXPECT_EQ(gripper_.state().width, 0);
  EXPECT_FALSE(gripper_.state().holding);
  EXPECT_EQ(gripper_.state().force, 0);
}

TEST_F(Gripper, OpeningLetsGoAtOnce) {
  ASSERT_TRUE(gripper_.close(30, SimulatedGripper::Contact{0.03, "BLOCK"}).has_value());
  settle();
  ASSERT_TRUE(gripper_.open(0.1, {}).has_value());
  EXPECT_FALSE(gripper_.state().holding);
  EXPECT_EQ(gripper_.state().held, "");
}

TEST_F(Gripper, HaltedJawsStandAndKeepWhatTheyHold) {
  ASSERT_TRUE(gripper_.open(0.1, {}).has_value());
  gripper_.step(0.1);
  gripper_.halt();
  const double width = gripper_.state().width;
  gripper_.step(0.1);
  EXPECT_EQ(gripper_.state().width, width);
  EXPECT_FALSE(gripper_.state().moving);
}

TEST_F(Gripper, RefusesWidthsAndForcesItDoesNotHave) {
  EXPECT_EQ(gripper_.open(0.2, {}).error().value, 0.2);
  EXPECT_EQ(gripper_.open(0.2, {}).error().upper, 0.11);
  EXPECT_FALSE(gripper_.open(std::nan(""), {}).has_value());
  EXPECT_EQ(gripper_.close(200, {}).error().value, 200);
  EXPECT_FALSE(gripper_.close(0, {}).has_value());
}

TEST(SimulatedBeam, OutOfRangeIsNothingNeverZero) {
  SimulatedBeam beam({.lower = 0.05, .upper = 1.0, .noise = 0.0002, .seed = 1});
  EXPECT_FALSE(beam.measure(std::nullopt).has_value());
  EXPECT_FALSE(beam.measure(0.04).has_value());
  EXPECT_FALSE(beam.measure(1.1).has_value());
  EXPECT_NEAR(beam.measure(0.5).value(), 0.5, 0.002);
  EXPECT_NE(beam.measure(0.5).value(), beam.measure(0.5).value());
}

}  // namespace
}  // namespace devices
