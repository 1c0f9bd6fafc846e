#include "devices/laser_distance_sensor/lds_servant.hpp"
#include "devices/world/world_servant.hpp"
#include "laboratory.hpp"
#include "robcl/laser_distance_sensor_client.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

/// A sensor at the origin that looks up at a plate half a metre above.
class LdsTest : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("LDS", servant_);
    sensor_ = create<robcl::LaserDistanceSensor>("LDS");
  }
  std::string fault() {
    const auto failed = sensor_.measure().get();
    if (failed) return "it measured";
    const auto why = failed.error().as<robcl::SensorFault>();
    return why ? why->reason : "another failure: " + failed.error().text;
  }

  SimulatedWorld world_{-1, {{"plate", {translate(0, 0, 0.55), {0.5, 0.5, 0.1}}, true, {}}}};
  WorldServant world_servant_{world_, [] {}};
  LdsServant servant_{lab_, "WORLD", "", robcl::Frame(), {.noise = 0}};
  robcl::LaserDistanceSensor sensor_;
};

TEST_F(LdsTest, MeasuresAlongTheZAxisOfItsBaseWhereverItIsMounted) {
  serve("WORLD", world_servant_);
  auto seen = sensor_.measure().get();
  ASSERT_TRUE(seen) << seen.error();
  EXPECT_TRUE(seen->valid);
  EXPECT_NEAR(seen->value, 0.5, 1e-9);

  const auto lease = gecos::actor(sensor_);
  ASSERT_TRUE(sensor_.mount("", translate(0, 0, 200_mm)).get());
  EXPECT_NEAR(sensor_.measure().get().value().value, 0.3, 1e-9);
  ASSERT_TRUE(sensor_.mount("", robcl::rotate_x(180_deg)).get());
  EXPECT_FALSE(sensor_.measure().get().value().valid) << "it looks down at nothing";
}

TEST_F(LdsTest, WithTheLaserOffItSaysWhatToDo) {
  serve("WORLD", world_servant_);
  const auto lease = gecos::actor(sensor_);
  ASSERT_TRUE(sensor_.power(false).get());
  EXPECT_EQ(fault(), "the laser is off: call power(true)");
  ASSERT_TRUE(sensor_.power(true).get());
  EXPECT_TRUE(sensor_.measure().get());
}

TEST_F(LdsTest, WithoutAWorldItIsAFaultAndNeverADistance) {
  EXPECT_NE(fault().find("no object is called WORLD"), std::string::npos);
  EXPECT_NE(fault().find("no object is called WORLD"), std::string::npos) << "nor the second time";
}

}  // namespace
}  // namespace devices
