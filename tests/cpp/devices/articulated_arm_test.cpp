// The joints of arms that have not six of them.
#include "../robcl/allocations.hpp"
#include "../robcl/arms.hpp"
#include "devices/arm/joints_servant.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "laboratory.hpp"
#include "robcl/articulated_arm_client.hpp"

namespace devices {
namespace {

using namespace std::chrono_literals;
using robcl::joints;

struct Articulated {
  const char* name;
  robcl::arm::ArmModel (*model)();
  JointValues start;
};
void PrintTo(const Articulated& arm, std::ostream* out) { *out << arm.name; }

class ArticulatedArmTest : public Laboratory, public ::testing::WithParamInterface<Articulated> {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("ARM", servant_);
    robot_ = create<robcl::ArticulatedArm>("ARM");
  }

  auto cycle() {
    return [this] {
      arm_.step(0.004);
      servant_.publish();
    };
  }

  const JointValues start_ = GetParam().start;
  SimulatedDriver driver_{start_, {.noise = 0}};
  ArmDevice arm_{
      GetParam().model(),
      {.tool_limits = {.speed = 1, .acceleration = 3, .turn_speed = 3, .turn_acceleration = 12}},
      driver_};
  const JointValues stood_ = arm_.sample().commanded;
  ArticulatedArmServant servant_{arm_, "a test"};
  robcl::ArticulatedArm robot_;
};

TEST_P(ArticulatedArmTest, MovesAllJointsAndReadsThem) {
  const auto lease = gecos::actor(robot_);
  robcl::JointPositions target = robot_.joints().get().value();
  ASSERT_EQ(target.position.size(), static_cast<std::size_t>(start_.size()));
  for (double& position : target.position) position += 0.1;
  const auto moved = get(robot_.move_joints(target), cycle());
  ASSERT_TRUE(moved) << moved.error();
  const auto measured = robot_.joints().get().value().position;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    EXPECT_NEAR(measured[i], start_[static_cast<Eigen::Index>(i)] + 0.1, 1e-3);
  }
  const auto commanded = robot_.commanded_joints().get().value().position;
  ASSERT_EQ(commanded.size(), target.position.size());
  for (std::size_t i = 0; i < commanded.size(); ++i) {
    EXPECT_NEAR(commanded[i], target.position[i], 1e-9);
  }
}

TEST_P(ArticulatedArmTest, AnotherNumberOfJointsIsRefusedWithTheNumberThatTheArmHas) {
  const auto lease = gecos::actor(robot_);
  const auto axes = static_cast<std::size_t>(start_.size());
  for (const std::size_t given : {axes - 1, axes + 1, std::size_t{0}}) {
    robcl::JointPositions target;
    target.position.resize(given);
    const auto refused = get(robot_.move_joints(target), cycle());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().detail, gecos::Detail::BadParameter);
    const std::string text = "target: it has " + std::to_string(given) +
                             " joint positions, but the arm has " + std::to_string(axes) +
                             " joints; give one for each joint";
    EXPECT_NE(refused.error().text.find(text), std::string::npos) << refused.error();
  }
  EXPECT_EQ(arm_.sample().commanded, stood_);
}

TEST_P(ArticulatedArmTest, DegreesInPlaceOfRadiansAreAskedAbout) {
  const auto lease = gecos::actor(robot_);
  robcl::JointPositions target = robot_.joints().get().value();
  target.position[0] = 90;
  const auto refused = get(robot_.move_joints(target), cycle());
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<robcl::JointLimit>();
  ASSERT_TRUE(why.has_value()) << refused.error();
  EXPECT_EQ(why->axis, 1U);
  std::ostringstream text;
  text << refused.error();
  EXPECT_NE(text.str().find("is the value in degrees?"), std::string::npos) << text.str();
  EXPECT_EQ(arm_.sample().commanded, stood_);
}

TEST_P(ArticulatedArmTest, APositionThatIsNotFiniteIsRefused) {
  const auto lease = gecos::actor(robot_);
  robcl::JointPositions target = robot_.joints().get().value();
  target.position.back() = std::numeric_limits<double>::quiet_NaN();
  const auto refused = get(robot_.move_joints(target), cycle());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, gecos::Detail::BadParameter) << refused.error();
  EXPECT_EQ(arm_.sample().commanded, stood_);
}

TEST_P(ArticulatedArmTest, HasNoConfigurationAndRefusesOneThatIsAskedFor) {
  const auto lease = gecos::actor(robot_);
  EXPECT_EQ(robot_.posture().get().value(), robcl::Configuration{}) << "any";
  const robcl::Configuration wanted{.hand = robcl::Wrist::FLIP};
  const auto refused = robot_.set_configuration(wanted).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, gecos::Detail::Rejected) << refused.error();
  const Frame here = robot_.tool().get().value();
  const auto moved = get(robot_.move(here, robcl::Trajectory{.configuration = wanted}), cycle());
  ASSERT_FALSE(moved);
  EXPECT_TRUE(moved.error().as<robcl::OutOfReach>().has_value()) << moved.error();
  EXPECT_NE(moved.error().text.find("no configurations to choose from"), std::string::npos)
      << moved.error();
  EXPECT_TRUE(robot_.set_configuration({}).get()) << "any";
  EXPECT_EQ(arm_.sample().commanded, stood_);
}

TEST_P(ArticulatedArmTest, StreamsSetPointsAndMeasurementsOfACycleWithOneStamp) {
  auto measured = robot_.joints(gecos::stream).value();
  auto commanded = robot_.commanded_joints(gecos::stream).value();
  for (int i = 0; i < 5; ++i) {
    cycle()();
    const auto set = commanded.next(0ms);
    const auto read = measured.next(0ms);
    ASSERT_TRUE(set && read);
    EXPECT_EQ(set->stamp, read->stamp);
    EXPECT_EQ(set->value.position.size(), static_cast<std::size_t>(start_.size()));
    EXPECT_EQ(read->value.position.size(), static_cast<std::size_t>(start_.size()));
  }
}

TEST_P(ArticulatedArmTest, TheControlLoopPublishesWithoutAllocating) {
  const auto measured = robot_.joints(gecos::stream);
  const auto commanded = robot_.commanded_joints(gecos::stream);
  ASSERT_TRUE(measured && commanded);
  for (int i = 0; i < 100; ++i) cycle()();
  const robcl::CountAllocations count;
  for (int i = 0; i < 1000; ++i) cycle()();
  EXPECT_EQ(count.so_far(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    OfFiveAndOfSevenJoints, ArticulatedArmTest,
    ::testing::Values(Articulated{"five", robcl::five_axes, joints({0, 20, 60, 30, 0})},
                      Articulated{"seven", robcl::seven_axes, joints({0, 20, 0, -90, 0, 70, 0})}),
    [](const auto& arm) { return std::string(arm.param.name); });

}  // namespace
}  // namespace devices
