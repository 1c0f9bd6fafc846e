#pragma once

#include <random>

#include "drivers/joint_driver.hpp"

namespace devices {

/// Joints that are simulated, and not perfect: they follow their command with a lag of first order,
/// and are seen through encoders with steps and noise.
class SimulatedDriver final : public JointDriver {
 public:
  struct Imperfection {
    double lag = 0.010;               ///< s until 63 % of a step of the command is done
    double encoder_counts = 262'144;  ///< per turn
    double noise = 0.4;               ///< standard deviation, counts
    unsigned seed = 1;
  };

  SimulatedDriver(const JointValues& start, const Imperfection& imperfection);

  JointValues measured() override;
  tl::expected<JointValues, DriverFault> exchange(const JointValues& command,
                                                  double seconds) override;

 private:
  Imperfection imperfection_;
  JointValues actual_;
  std::mt19937 random_;
  std::normal_distribution<double> noise_;
};

}  // namespace devices
