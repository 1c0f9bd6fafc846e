#include "devices/world/world_servant.hpp"
#include "laboratory.hpp"
#include "robcl/world_client.hpp"

namespace devices {
namespace {

using robcl::translate;

class WorldServantTest : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("WORLD", servant_);
    world_ = create<robcl::World>("WORLD");
  }
  gecos::Failure place(const std::string& name) {
    const auto lease = gecos::actor(world_);
    const auto placed = world_.place(name, translate(0, 0, 1)).get();
    return placed ? gecos::Failure{} : placed.error();
  }

  SimulatedWorld simulated_{-1,
                            {{"table", {translate(0, 0, -0.5), {2, 2, 1}}, true, {}},
                             {"block", {translate(0, 0, 0.05), {0.06, 0.06, 0.1}}, false, {}}}};
  int caught_up_ = 0;
  WorldServant servant_{simulated_, [this] { ++caught_up_; }};
  robcl::World world_;
};

TEST_F(WorldServantTest, WhatIsCarriedIsBroughtUpToDateBeforeEveryAnswer) {
  ASSERT_TRUE(world_.bodies().get());
  ASSERT_TRUE(world_.find("block").get());
  ASSERT_TRUE(world_.cast(translate(0, 0, 2) * robcl::rotate_x(3.1415926535), 5).get());
  EXPECT_EQ(caught_up_, 3);
}

TEST_F(WorldServantTest, AnUnknownBodyIsToldWhichThereAre) {
  const auto why = place("blok").as<robcl::UnknownBody>();
  ASSERT_TRUE(why.has_value());
  EXPECT_EQ(why->known, (std::vector<std::string>{"table", "block"}));
}

TEST_F(WorldServantTest, WhatIsFixedOrHeldIsNotPutElsewhere) {
  EXPECT_EQ(place("table").text, "the body 'table' is fixed and cannot be placed");
  simulated_.track("GRIPPER", "block", robcl::Frame());
  const gecos::Failure held = place("block");
  EXPECT_EQ(held.detail, gecos::Detail::Rejected);
  EXPECT_EQ(held.text, "a gripper holds the body 'block': open the gripper first");
}

TEST_F(WorldServantTest, ALengthBelowZeroIsABadParameter) {
  const auto cast = world_.cast(robcl::Frame(), -1).get();
  ASSERT_FALSE(cast);
  EXPECT_EQ(cast.error().detail, gecos::Detail::BadParameter);
}

}  // namespace
}  // namespace devices
