#pragma once

#include <optional>
#include <random>

#include "gecos/base/mutex.hpp"

namespace devices {

/// Computes the reading of a laser distance sensor from the true distance. Thread-safe.
class SimulatedBeam {
 public:
  struct Settings {
    double lower = 0.050;   ///< smallest measured distance, m
    double upper = 1.000;   ///< greatest measured distance, m
    double noise = 0.0002;  ///< standard deviation, m
    unsigned seed = 1;
  };

  explicit SimulatedBeam(const Settings& settings);

  const Settings& settings() const { return settings_; }

  /// The measured distance, m; nullopt if the beam meets nothing within its range.
  std::optional<double> measure(std::optional<double> distance);

 private:
  const Settings settings_;
  gecos::Mutex guard_;
  std::mt19937 random_ GECOS_GUARDED_BY(guard_);
  std::normal_distribution<double> noise_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
