#include "drivers/simulated_driver.hpp"

#include <cmath>
#include <numbers>

namespace devices {

SimulatedDriver::SimulatedDriver(const JointValues& start, const Imperfection& imperfection)
    : imperfection_(imperfection),
      actual_(start),
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

tl::expected<JointValues, DriverFault> SimulatedDriver::exchange(const JointValues& command,
                                                                 double seconds) {
  const double done = 1 - std::exp(-seconds / imperfection_.lag);
  actual_ += done * (command - actual_);
  return measured();
}

}  // namespace devices
