#pragma once

#include <atomic>
#include <string>

#include "devices/laser_distance_sensor/simulated_beam.hpp"
#include "devices/support/carrier.hpp"
#include "gecos/reconnecting.hpp"
#include "robcl/laser_distance_sensor_server.hpp"
#include "robcl/world_client.hpp"

namespace devices {

/// The servant of a simulated sensor: implements the interface `robcl::LaserDistanceSensor` with a
/// SimulatedBeam. Gets the true distance from the simulated world, an object with the interface
/// `robcl::World`. Thread-safe. Handlers wait for the answers of that object.
class LdsServant final : public robcl::LaserDistanceSensorServant {
 public:
  LdsServant(gecos::Lab& lab, std::string world, const std::string& carrier,
             const robcl::Frame& carrier_from_base, const SimulatedBeam::Settings& settings);

  /// Sends a sample of the measured distance if the sensor can measure now. Only one thread may
  /// call this method.
  void publish();

 private:
  gecos::Result<robcl::Frame> base() override { return mounting_.base(); }
  gecos::Result<std::string> parent() override { return mounting_.parent(); }
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& offset) override {
    return mounting_.mount(carrier, offset);
  }
  gecos::Result<robcl::Distance> beam() override { return measure(); }
  gecos::Result<robcl::Distance> measure() override;
  gecos::Result<void> power(bool on) override;

  tl::expected<robcl::RayHit, std::string> cast();

  gecos::Reconnecting<robcl::World> world_;
  Mounting mounting_;
  SimulatedBeam beam_;
  std::atomic<bool> on_{true};
};

}  // namespace devices
