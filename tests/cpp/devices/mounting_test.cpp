#include "devices/support/carrier.hpp"
#include "rx90_fixture.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

class MountingTest : public Rx90Laboratory {
 protected:
  /// Until what the carrier says is known.
  Frame heard(Carrier& carrier) {
    auto frame = carrier.frame();
    for (; !frame; frame = carrier.frame()) {
      cycle()();
      carrier.tick();
    }
    return *frame;
  }
};

TEST_F(MountingTest, ACarrierThatWasNotHeardYetIsNotGuessed) {
  Carrier carrier(lab_);
  carrier.follow("RX90");
  const auto unknown = carrier.frame();
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error(),
            "the position of the flange of 'RX90' is unknown: 'RX90' sent no sample yet");
  EXPECT_TRUE(near(heard(carrier), arm_.sample().flange, 1e-3, 1e-2));
}

TEST_F(MountingTest, WhoFollowsTheWorldStands) {
  Carrier carrier(lab_);
  carrier.follow("RX90");
  carrier.follow("");
  EXPECT_EQ(carrier.frame().value(), Frame());
}

TEST_F(MountingTest, ADeviceGoesWithTheFlangeThatItIsMountedOn) {
  Mounting mounting(lab_, "RX90", translate(0, 0, 100_mm));
  heard(mounting.carrier());
  EXPECT_TRUE(
      near(mounting.base().value(), arm_.sample().flange * translate(0, 0, 100_mm), 1e-3, 1e-2));

  const auto lease = gecos::actor(robot_);
  const Frame before = mounting.base().value();
  ASSERT_TRUE(get(robot_.move(robot_.tool().get().value() * translate(0, 200_mm, 0)), cycle()));
  cycle()();
  EXPECT_TRUE(near(mounting.base().value(), before * translate(0, 200_mm, 0), 2e-3, 1e-2));
}

TEST_F(MountingTest, MountingOnWhatIsNoArmChangesNothing) {
  Mounting mounting(lab_, "", translate(1, 0, 0));
  ASSERT_FALSE(mounting.mount("BROKER", Frame()));
  EXPECT_EQ(mounting.parent(), "");
  EXPECT_EQ(mounting.base().value(), translate(1, 0, 0));
}

}  // namespace
}  // namespace devices
