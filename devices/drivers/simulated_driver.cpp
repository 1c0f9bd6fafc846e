#include "devices/drivers/simulated_driver.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace devices {

SimulatedDriver::SimulatedDriver(const JointValues& start, const Imperfection& imperfection)
    : imperfection_(imperfection),
      actual_(start),
      speed_(JointValues::Zero(start.size())),
      random_(imperfection.seed),
      noise_(0, imperfection.noise) {}

JointValues SimulatedDriver::measured() {
  const double count = 2 * std::numbers::pi / imperfection_.encoder_counts;
  JointValues seen = actual_;
  for (Eigen::Index i = 0; i < seen.size(); ++i) {
    seen[i] = std::round(seen[i] / count + noise_(random_)) * count;
  }
  return seen;
}

JointState SimulatedDriver::state() {
  JointState state;
  state.power = power_;
  state.brakes = power_ == DrivePower::On ? Brakes::Released : Brakes::Engaged;
  state.position = measured();
  state.velocity = speed_;
  if (power_ == DrivePower::Fault) state.fault = fault_;
  return state;
}

tl::expected<void, DriverFault> SimulatedDriver::enable() {
  if (power_ == DrivePower::Fault) return tl::unexpected(DriverFault{fault_});
  power_ = DrivePower::On;
  speed_.setZero();
  return {};
}

tl::expected<void, DriverFault> SimulatedDriver::disable() {
  if (power_ != DrivePower::Fault) power_ = DrivePower::Off;
  speed_.setZero();
  return {};
}

tl::expected<void, DriverFault> SimulatedDriver::reset() {
  if (power_ == DrivePower::Fault) power_ = DrivePower::Off;
  return {};
}

void SimulatedDriver::break_down(std::string fault) {
  power_ = DrivePower::Fault;
  fault_ = std::move(fault);
  speed_.setZero();
}

tl::expected<void, DriverFault> SimulatedDriver::write(const JointCommand& command,
                                                       double since_last) {
  if (power_ != DrivePower::On) return {};
  const double done = 1 - std::exp(-since_last / imperfection_.lag);
  const JointValues before = actual_;
  if (imperfection_.mode == ControlMode::Position) {
    actual_ += done * (command.position - actual_);
    speed_ = (actual_ - before) / since_last;
  } else {
    speed_ += done * (command.velocity - speed_);
    actual_ += since_last * speed_;
  }
  return {};
}

}  // namespace devices
