// Simulated arms at other speeds than that of real time: the drivers get the same set points.
#include "devices/support/lab_clock.hpp"

#include <chrono>
#include <cstdlib>
#include <vector>

#include "devices/arm/arm_program.hpp"
#include "devices/puma560/puma560_files.hpp"
#include "devices/support/periodic.hpp"
#include "rx90_fixture.hpp"

namespace devices {
namespace {

using namespace robcl::literals;
using namespace std::chrono_literals;

/// Keeps what the control loop writes.
class RecordingDriver final : public JointDriver {
 public:
  explicit RecordingDriver(const JointValues& start) : joints_(start, {}) {}

  /// From now on, set points other than `standing` are kept.
  void record(const JointValues& standing) { set_points_ = {standing}; }

  Properties properties() const override { return joints_.properties(); }
  tl::expected<JointState, DriverFault> read() override { return joints_.read(); }
  tl::expected<void, DriverFault> write(const JointCommand& command, double since_last) override {
    if (set_points_.back() != command.position) set_points_.push_back(command.position);
    return joints_.write(command, since_last);
  }
  tl::expected<void, DriverFault> enable() override { return joints_.enable(); }
  tl::expected<void, DriverFault> disable() override { return joints_.disable(); }
  tl::expected<void, DriverFault> reset() override { return joints_.reset(); }

  /// @pre the control loop has ended
  const std::vector<JointValues>& set_points() const { return set_points_; }

 private:
  SimulatedDriver joints_;
  std::vector<JointValues> set_points_;  // one for all cycles in which the arm stands
};

class Uninterrupted final : public MotionWatcher {
 public:
  bool interrupted() override { return false; }
  void progress(double, double) override {}
};

struct Motion {
  std::vector<JointValues> set_points;  ///< one for all cycles in which the arm stands
  double reached = 0;                   ///< speed of the clock
  std::uint64_t missed_cycles = 0;
};

/// Moves an arm on a straight line and back by a joint move.
Motion moved(const ArmDescription& arm, double clock_speed) {
  RecordingDriver driver(arm.start);
  ArmDevice device(arm.model,
                   {.tool_limits = arm.tool_limits,
                    .seconds_to_full_acceleration = arm.seconds_to_full_acceleration,
                    .tool_offset = arm.tool_offset,
                    .clock_speed = clock_speed},
                   driver);
  Uninterrupted watcher;
  Motion motion;
  driver.record(device.sample().commanded);
  const Frame start = device.sample().tool;  // before the loop begins: each cycle has other noise
  {
    const Periodic control(device.clock(), 4ms, [&](double seconds) { device.step(seconds); });
    const Frame goal = robcl::translate(50_mm, 80_mm, -100_mm) * start;
    const auto there = device.move(goal, PathKind::Straight, {}, watcher);
    EXPECT_TRUE(there) << to_string(there.error());
    const auto back = device.move_joints(arm.start, {}, watcher);
    EXPECT_TRUE(back) << to_string(back.error());
    EXPECT_LT((device.sample().joints - arm.start).cwiseAbs().maxCoeff(), 1e-3);
    motion.missed_cycles = device.missed_cycles();
    motion.reached = device.clock().reached();
  }
  motion.set_points = driver.set_points();
  return motion;
}

class LabClockTest : public ::testing::TestWithParam<const char*> {
 protected:
  ArmDescription arm() const {
    return read_arm(ROBCL_SOURCE_DIR "/devices/arms/" + std::string(GetParam())).value();
  }
};

TEST_P(LabClockTest, TheSetPointsOfAMotionDoNotDependOnTheSpeed) {
  const ArmDescription described = arm();
  const auto expected = moved(described, 0.5).set_points;
  EXPECT_GT(expected.size(), 100U);
  // At the last speed, any machine is overloaded.
  for (const double speed : {1.0, 20.0, LabClock::fastest}) {
    const Motion motion = moved(described, speed);
    if (speed == 1 && motion.missed_cycles > 0) {  // of a busy machine, which delays the motion
      EXPECT_GE(motion.set_points.size(), expected.size());
      continue;
    }
    ASSERT_EQ(motion.set_points.size(), expected.size()) << "at speed " << speed;
    double farthest = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      farthest = std::max(farthest, (motion.set_points[i] - expected[i]).cwiseAbs().maxCoeff());
    }
    EXPECT_LE(farthest, 1e-9) << "at speed " << speed;
    EXPECT_EQ(motion.missed_cycles, 0U);
    EXPECT_GT(motion.reached, 0);
    if (speed == LabClock::fastest) {
      EXPECT_LT(motion.reached, speed) << "a cycle takes longer than 40 ns";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, LabClockTest,
                         ::testing::Values("rx90.toml", "puma560.toml", "iiwa14.toml"),
                         [](const auto& arm) {
                           const std::string file = arm.param;
                           return file.substr(0, file.find('.'));
                         });

/// Starts the program of an arm with real joints, with `words`; it must not touch the joints.
std::string refusal(std::vector<std::string> words) {
  words.insert(words.begin(), "real-arm");
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  const ArmProgram program{"real-arm", rx90_files, [](const ArmDescription&) {
                             ADD_FAILURE() << "the drives were connected";
                             return std::unique_ptr<JointDriver>();
                           }};
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(serve_arm(program, static_cast<int>(pointers.size()), pointers.data()), 2);
  const std::string said = ::testing::internal::GetCapturedStderr();
  return said.substr(0, said.find('\n'));
}

TEST(LabClock, AnArmWithRealJointsRefusesAnySpeedButThatOfRealTime) {
  EXPECT_EQ(refusal({"--clock", "10"}),
            "real-arm: '--clock' is 10, but the joints of RX90 are real; only simulated devices "
            "have another clock than 1");
  ::setenv("ROBCL_CLOCK", "2.5", 1);
  EXPECT_EQ(refusal({}),
            "real-arm: ROBCL_CLOCK is 2.5, but the joints of RX90 are real; only simulated devices "
            "have another clock than 1");
  ::unsetenv("ROBCL_CLOCK");
}

TEST_F(Rx90Laboratory, AnArmSaysTheSpeedOfItsClock) {
  EXPECT_EQ(robot_.clock_speed().get().value(), 1);
  arm_.clock().set_reached(0.75);
  EXPECT_EQ(robot_.reached_clock_speed().get().value(), 0.75);
}

}  // namespace
}  // namespace devices
