#include "devices/laser_distance_sensor/simulated_beam.hpp"

namespace devices {

SimulatedBeam::SimulatedBeam(const Settings& settings)
    : settings_(settings), random_(settings.seed), noise_(0, settings.noise) {}

std::optional<double> SimulatedBeam::measure(std::optional<double> distance) {
  if (!distance) return std::nullopt;
  const gecos::MutexLock lock(guard_);
  const double seen = *distance + noise_(random_);
  if (seen < settings_.lower || seen > settings_.upper) return std::nullopt;
  return seen;
}

}  // namespace devices
