// Drives that the tests let stand, break and lie.
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include "devices/drivers/joint_driver.hpp"
#include "robcl/motion/playback.hpp"

namespace devices {

/// The motion of a plan, for ArmController::start.
inline std::shared_ptr<robcl::motion::Playback> playing(robcl::motion::Plan plan) {
  return std::make_shared<robcl::motion::Playback>(std::move(plan));
}

inline std::int64_t unix_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Joints that stand where the test says, whatever is commanded.
class StandingDriver : public JointDriver {
 public:
  explicit StandingDriver(JointValues where) : stands(std::move(where)) {}

  tl::expected<JointState, DriverFault> read() override { return state(); }
  tl::expected<void, DriverFault> write(const JointCommand&, double) override {
    if (broken) return tl::unexpected(DriverFault{"no answer from the drives"});
    return {};
  }
  tl::expected<void, DriverFault> enable() override { return {}; }
  tl::expected<void, DriverFault> disable() override { return {}; }
  tl::expected<void, DriverFault> reset() override { return {}; }

  JointState state() const {
    JointState now;
    now.power = power;
    now.brakes = brakes;
    now.position = stands;
    if (tells_time) now.measured_at_ns = unix_ns();
    return now;
  }

  JointValues stands;
  DrivePower power = DrivePower::On;
  Brakes brakes = Brakes::Released;
  bool broken = false;
  bool tells_time = true;
};

}  // namespace devices
