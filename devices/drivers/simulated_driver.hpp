#pragma once

#include <random>

#include "devices/drivers/joint_driver.hpp"

namespace devices {

/// A driver of simulated, imperfect joints. The joints follow a commanded position or velocity with
/// a first-order lag. Encoders of finite resolution measure the joints with noise.
class SimulatedDriver final : public JointDriver {
 public:
  struct Imperfection {
    double lag = 0.010;  ///< time constant of the lag, s: after it, 63 % of a step is done
    double encoder_counts = 262'144;  ///< counts per turn
    double noise = 0.4;               ///< standard deviation, counts
    unsigned seed = 1;
    ControlMode mode = ControlMode::Position;
    double period = 0.004;  ///< s, of the control loop
  };

  SimulatedDriver(const JointValues& start, const Imperfection& imperfection);

  Properties properties() const override {
    return {.mode = imperfection_.mode, .period = imperfection_.period};
  }
  tl::expected<JointState, DriverFault> read() override { return state(); }
  tl::expected<void, DriverFault> write(const JointCommand& command, double since_last) override;
  tl::expected<void, DriverFault> enable() override;
  tl::expected<void, DriverFault> disable() override;
  tl::expected<void, DriverFault> reset() override;

  /// Returns the positions of the joints in rad, as the encoders measure them now.
  JointValues measured();
  /// Makes the drives fail with the text `fault`. The brakes hold the arm until `reset` is called.
  void break_down(std::string fault);

 private:
  JointState state();

  Imperfection imperfection_;
  DrivePower power_ = DrivePower::Off;
  std::string fault_;
  JointValues actual_;
  JointValues speed_;
  std::mt19937 random_;
  std::normal_distribution<double> noise_;
};

}  // namespace devices
