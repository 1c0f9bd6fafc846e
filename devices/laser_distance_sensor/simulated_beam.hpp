#pragma once

#include <optional>
#include <random>

#include "gecos/base/mutex.hpp"

namespace devices {

/// Computes the measured value of a laser distance sensor from the true distance. Thread-safe.
class SimulatedBeam {
 public:
  struct Settings {
    double lower = 0.050;   ///< smallest distance that can be measured, m
    double upper = 1.000;   ///< greatest distance that can be measured, m
    double noise = 0.0002;  ///< standard deviation, m
    unsigned seed = 1;
  };

  explicit SimulatedBeam(const Settings& settings);

  const Settings& settings() const { return settings_; }

  /// Returns the measured distance in m for the true distance `distance`. Returns nullopt if the
  /// beam hits nothing, or if the measured distance is outside the sensor's range.
  std::optional<double> measure(std::optional<double> distance);

 private:
  const Settings settings_;
  gecos::Mutex guard_;
  std::mt19937 random_ GECOS_GUARDED_BY(guard_);
  std::normal_distribution<double> noise_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
