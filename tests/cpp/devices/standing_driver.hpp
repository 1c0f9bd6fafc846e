// Drives that the tests let stand, break and lie.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

/// Joints that are where they were told to be. Remembers all set points.
class RecordingDriver : public StandingDriver {
 public:
  /// `period`: of the control loop, in s.
  explicit RecordingDriver(JointValues where, double period = 0.004)
      : StandingDriver(std::move(where)), period_(period) {
    tells_time = false;  // the tests step through cycles faster or slower than real time
  }

  Properties properties() const override { return {.period = period_}; }
  tl::expected<void, DriverFault> write(const JointCommand& command, double) override {
    stands = command.position;
    all.push_back(stands);
    return {};
  }
  std::vector<JointValues> all;

 private:
  const double period_;
};

/// Drives that need time to turn on.
class SlowDrives : public StandingDriver {
 public:
  explicit SlowDrives(JointValues where) : StandingDriver(std::move(where)) {
    power = DrivePower::Off;
  }
  tl::expected<JointState, DriverFault> read() override {
    if (power == DrivePower::TurningOn && --cycles_left <= 0) power = DrivePower::On;
    JointState now = state();
    now.fault = fault;
    return now;
  }
  tl::expected<void, DriverFault> enable() override {
    if (!locked.empty()) return tl::unexpected(DriverFault{locked});
    power = DrivePower::TurningOn;
    return {};
  }
  tl::expected<void, DriverFault> reset() override {
    if (!kept.empty()) return tl::unexpected(DriverFault{kept});
    power = DrivePower::Off;
    ++resets;
    return {};
  }
  std::atomic<int> resets{0};
  std::atomic<int> cycles_left{1'000'000};
  std::string locked;  // why they cannot be enabled
  std::string kept;    // why the fault cannot be cleared
  std::string fault;   // text of a fault
};

}  // namespace devices
