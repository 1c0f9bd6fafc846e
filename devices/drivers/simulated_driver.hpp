#pragma once

#include <random>

#include "drivers/joint_driver.hpp"

namespace devices {

/// Simulated, imperfect joints. They follow a commanded position or velocity with a first-order
/// lag, and are measured by encoders of finite resolution with noise. The joints have no mass, so
/// there is no torque mode.
class SimulatedDriver final : public JointDriver {
 public:
  struct Imperfection {
    double lag = 0.010;               ///< time constant of the lag, s: time to do 63 % of a step
    double encoder_counts = 262'144;  ///< counts per turn
    double noise = 0.4;               ///< standard deviation, counts
    unsigned seed = 1;
  };

  SimulatedDriver(const JointValues& start, const Imperfection& imperfection);

  Capabilities capabilities() const override;
  tl::expected<JointState, DriverFault> read() override { return state(); }
  tl::expected<void, DriverFault> enable(ControlMode mode) override;
  tl::expected<void, DriverFault> disable() override;
  tl::expected<void, DriverFault> reset() override;
  tl::expected<JointState, DriverFault> exchange(const JointCommand& command,
                                                 double seconds) override;

  /// Positions of the joints as the encoders measure them now, rad.
  JointValues measured();
  /// Makes the drives fail with the text `fault`; the brakes hold the arm until a reset.
  void break_down(std::string fault);

 private:
  JointState state();

  Imperfection imperfection_;
  DrivePower power_ = DrivePower::Off;
  ControlMode mode_ = ControlMode::Position;
  std::string fault_;
  JointValues actual_;
  JointValues speed_;
  std::mt19937 random_;
  std::normal_distribution<double> noise_;
};

}  // namespace devices
