// Drivers that throw, or whose answers cannot be true.
#include "devices/drivers/supervised_driver.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "driven_arm.hpp"

namespace devices {
namespace {

/// Gives the answer that the test makes of the true one, after ten commands.
class LyingDriver : public StandingDriver {
 public:
  explicit LyingDriver(std::function<void(JointState&)> lie)
      : StandingDriver(start), lie_(std::move(lie)) {}
  tl::expected<void, DriverFault> write(const JointCommand&, double) override {
    ++commands_;
    return {};
  }
  tl::expected<JointState, DriverFault> read() override {
    JointState answer = state();
    if (commands_ >= 10) lie_(answer);
    return answer;
  }

 private:
  std::function<void(JointState&)> lie_;
  int commands_ = 0;
};

struct Lie {
  std::function<void(JointState&)> tell;
  std::string noticed;
};

TEST(LyingDriver, EndsTheMotionWithAFaultThatSaysWhyItCannotBeTrue) {
  const double none = std::nan("");
  for (const Lie& lie : std::vector<Lie>{
           {[&](JointState& state) { state.position[3] = none; }, "a joint position is not finite"},
           {[](JointState& state) { state.position.conservativeResize(5); },
            "the answer has 5 joint positions, but the arm has 6 joints"},
           {[&](JointState& state) { state.velocity = JointValues::Constant(6, none); },
            "the joint velocities are not 6 finite numbers"},
           {[](JointState& state) { state.measured_at_ns -= 60'000'000'000; },
            "the measurement is 60 s old"},
           {[](JointState& state) { state.measured_at_ns += 60'000'000'000; },
            "the time of the measurement is 60 s in the future"},
           {[](JointState& state) { state.position[2] += 0.5; },
            "joint 3 moved by 0.5 rad in 0.004 s; the joint can move by at most 0.02 rad in this "
            "time"}}) {
    LyingDriver driver(lie.tell);
    ArmController controller(robcl::rx90(), {}, driver);
    const auto outcome = outcome_of(controller);
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->end, ArmController::End::Fault);
    EXPECT_EQ(outcome->fault.text, "the driver's answer cannot be true: " + lie.noticed);
  }
}

TEST(ThrowingDriver, EndsTheMotionWithAFaultWhateverItThrows) {
  for (const auto& [throwing, text] :
       std::vector<std::pair<std::function<void(JointState&)>, std::string>>{
           {[](JointState&) { throw std::runtime_error("line cut"); },
            "the driver threw: line cut"},
           {[](JointState&) { throw 7; },
            "the driver threw an exception that is not a std::exception"}}) {
    LyingDriver driver(throwing);
    ArmController controller(robcl::rx90(), {}, driver);
    const auto outcome = outcome_of(controller);
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->end, ArmController::End::Fault);
    EXPECT_EQ(outcome->fault.text, text);
  }
}

}  // namespace
}  // namespace devices
