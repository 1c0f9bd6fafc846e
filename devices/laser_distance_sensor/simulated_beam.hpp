#pragma once

#include <optional>
#include <random>

#include "gecos/base/mutex.hpp"

namespace devices {

/// The reading of a laser distance sensor for a true distance. Any thread.
class SimulatedBeam {
 public:
  struct Settings {
    double lower = 0.050;   ///< m
    double upper = 1.000;   ///< m
    double noise = 0.0002;  ///< standard deviation, m
    unsigned seed = 1;
  };

  explicit SimulatedBeam(const Settings& settings);

  const Settings& settings() const { return settings_; }

  /// The measured distance; nullopt if the beam meets nothing, or nothing within the range.
  std::optional<double> measure(std::optional<double> distance);

 private:
  const Settings settings_;
  gecos::Mutex guard_;
  std::mt19937 random_ GECOS_GUARDED_BY(guard_);
  std::normal_distribution<double> noise_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
