#include "devices/laser_distance_sensor/lds_servant.hpp"

#include <utility>

namespace devices {
LdsServant::LdsServant(gecos::Lab& lab, std::string world, const std::string& carrier,
                       const robcl::Frame& carrier_from_base,
                       const SimulatedBeam::Settings& settings)
    : world_(lab, std::move(world)), mounting_(lab, carrier, carrier_from_base), beam_(settings) {}

tl::expected<robcl::RayHit, std::string> LdsServant::cast() {
  const auto origin = mounting_.base();
  if (!origin) return tl::unexpected(origin.error().failure().text);
  const auto hit = world_.call(
      [&](const robcl::World& world) { return world.cast(*origin, beam_.settings().upper).get(); });
  if (!hit) return tl::unexpected(hit.error().text);
  return *hit;
}

gecos::Result<robcl::Distance> LdsServant::measure() {
  if (!on_.load()) {
    return tl::unexpected(robcl::SensorFault{"the laser is off: call power(true)"});
  }
  const auto hit = cast();
  if (!hit) return tl::unexpected(robcl::SensorFault{hit.error()});
  const auto seen = beam_.measure(hit->hit ? std::optional(hit->range) : std::nullopt);
  return robcl::Distance{seen.value_or(0), seen.has_value(), beam_.settings().lower,
                         beam_.settings().upper, static_cast<double>(gecos::unix_now_ns()) * 1e-9};
}

gecos::Result<void> LdsServant::power(bool on) {
  on_.store(on);
  return {};
}

void LdsServant::publish() {
  mounting_.carrier().tick();
  if (!on_.load()) return;
  if (const auto now = measure()) publish_beam(*now);
}

}  // namespace devices
