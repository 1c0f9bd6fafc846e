// A reset of the drives, as an operation of an arm.
#include <thread>

#include "../robcl/arms.hpp"
#include "devices/arm/joints_servant.hpp"
#include "laboratory.hpp"
#include "robcl/six_axis_client.hpp"
#include "standing_driver.hpp"

namespace devices {
namespace {

/// Has no interface of its own: one of the inherited operations resets the drives.
class ResetArm final : public SixAxisServant {
 public:
  using SixAxisServant::SixAxisServant;

 private:
  gecos::Result<void> set_configuration(const robcl::Configuration&,
                                        gecos::Execution<>& run) override {
    return restart_drives(run);
  }
};

class ResetTest : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("ARM", servant_);
    robot_ = create<robcl::SixAxis>("ARM");
    lease_.emplace(gecos::actor(robot_));
  }

  auto reset() { return robot_.set_configuration({}); }

  /// The reset has begun, and the drives turn on, but are not on.
  template <class Command>
  void has_begun(const Command& command) {
    while (driver_.resets == 0) std::this_thread::yield();
    EXPECT_EQ(command.state(), gecos::State::Running);
  }

  SlowDrives driver_{robcl::joints({0, -20, 110, 0, 90, 0})};
  ArmDevice arm_{robcl::rx90(), {}, driver_};
  ResetArm servant_{arm_, "a test"};
  robcl::SixAxis robot_;
  std::optional<decltype(gecos::actor(std::declval<robcl::SixAxis&>()))> lease_;
  std::jthread loop_{[this](const std::stop_token& over) {
    while (!over.stop_requested()) {
      arm_.step(0.004);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }};
};

TEST_F(ResetTest, IsFinishedWhenTheDrivesAreOn) {
  const auto command = reset();
  has_begun(command);
  driver_.cycles_left = 1;
  const auto done = command.get();
  ASSERT_TRUE(done) << done.error();
  EXPECT_EQ(arm_.power(), DrivePower::On);
}

TEST_F(ResetTest, FailsWithTheWordsOfTheDriver) {
  driver_.locked = "the emergency stop is pressed";
  const auto failed = reset().get();
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().detail, gecos::Detail::Fault);
  EXPECT_NE(failed.error().text.find("the emergency stop is pressed"), std::string::npos);
}

TEST_F(ResetTest, IsEndedByACancel) {
  const auto command = reset();
  has_begun(command);
  command.cancel();
  const auto ended = command.get();
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().detail, gecos::Detail::Canceled) << ended.error();
}

TEST_F(ResetTest, IsEndedByAStop) {
  const auto command = reset();
  has_begun(command);
  ASSERT_TRUE(gecos::stop(robot_).get());
  const auto ended = command.get();
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().detail, gecos::Detail::Stopped) << ended.error();
}

TEST_F(ResetTest, IsEndedByTheEndOfItsServer) {
  const auto command = reset();
  has_begun(command);
  stop_serving();
  EXPECT_FALSE(command.get());
  EXPECT_NE(arm_.power(), DrivePower::On);
}

}  // namespace
}  // namespace devices
