// The servants of all arms, over an arm of another make.
#include "devices/arm/joints_servant.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "devices/puma560/puma560_files.hpp"
#include "laboratory.hpp"
#include "robcl/frames/units.hpp"
#include "robcl/puma560_client.hpp"
#include "robcl/puma560_server.hpp"

namespace devices {
namespace {

using robcl::translate;
using namespace robcl::literals;

class Puma560Arm final : public robcl::Puma560Servant, public SixAxisServant {
 public:
  using devices::SixAxisServant::SixAxisServant;
};

class Puma560Test : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("ARM", servant_);
    robot_ = create<robcl::Manipulator>("ARM");
  }

  auto cycle() {
    return [this] {
      arm_.step(0.004);
      servant_.publish();
    };
  }

  const ArmDescription described_ = parse_arm(puma560_files).value();
  SimulatedDriver driver_{described_.start, {}};
  ArmDevice arm_{described_.model,
                 {.tool_limits = described_.tool_limits, .tool_offset = described_.tool_offset},
                 driver_};
  Puma560Arm servant_{arm_, described_.place};
  robcl::Manipulator robot_;
};

TEST_F(Puma560Test, IsMovedByAProgramThatKnowsManipulatorAlone) {
  const auto lease = gecos::actor(robot_);
  ASSERT_TRUE(lease) << lease.error();
  const Frame goal = Frame::from_euler_zyz(500_mm, 200_mm, 250_mm, 0, 180_deg, 0);
  ASSERT_TRUE(get(robot_.move(goal), cycle()));
  EXPECT_LT(distance(robot_.tool().get().value(), goal), 1e-4);
  const Frame down = goal * translate(0, 0, 200_mm);
  const auto moved =
      get(robot_.move(down, robcl::Trajectory{.path = robcl::PathType::STRAIGHT}), cycle());
  ASSERT_TRUE(moved) << moved.error();
  EXPECT_LT(distance(robot_.tool().get().value(), down), 1e-4);
}

TEST_F(Puma560Test, SaysInWhichConfigurationItIsAndLeavesOutWhatASingularityHides) {
  const robcl::Configuration tool_down = robot_.posture().get().value();
  EXPECT_EQ(tool_down.arm, robcl::Shoulder::RIGHTY);
  EXPECT_EQ(tool_down.bend, robcl::Elbow::ABOVE);
  EXPECT_EQ(tool_down.hand, robcl::Wrist::FLIP);

  JointValues straight_wrist = described_.start;
  straight_wrist[4] = 0;
  SimulatedDriver exact(straight_wrist, {.noise = 0});
  ArmDevice arm(arm_.model(), {}, exact);
  Puma560Arm servant(arm, "");
  serve("STRAIGHT", servant);
  const auto straight = create<robcl::Manipulator>("STRAIGHT").posture().get().value();
  EXPECT_EQ(straight.bend, robcl::Elbow::ABOVE);
  EXPECT_FALSE(straight.hand.has_value()) << straight;
  stop_serving();
}

TEST(SixAxisServant, RefusesAnArmOfAnotherNumberOfJoints) {
  const auto described = read_arm(ROBCL_SOURCE_DIR "/devices/arms/iiwa14.toml").value();
  SimulatedDriver driver(described.start, {});
  ArmDevice arm(described.model, {}, driver);
  try {
    Puma560Arm servant(arm, "");
    FAIL() << "a six-axis arm of seven joints";
  } catch (const std::invalid_argument& refused) {
    EXPECT_STREQ(refused.what(),
                 "an arm with the interface SixAxis has six joints, but iiwa14 has 7");
  }
}

TEST_F(Puma560Test, IsRefusedACarrierInItsOwnWords) {
  const auto lease = gecos::actor(robot_);
  const auto refused = robot_.mount("RX90", Frame()).get();
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::MountRefused>();
  ASSERT_TRUE(why.has_value()) << refused.error();
  EXPECT_EQ(why->reason,
            "a Puma 560 stands on its pedestal, not on 'RX90': leave the carrier empty");
}

}  // namespace
}  // namespace devices
