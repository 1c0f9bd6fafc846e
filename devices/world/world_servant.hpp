#pragma once

#include <functional>

#include "devices/world/simulated_world.hpp"
#include "robcl/world_server.hpp"

namespace devices {

/// The servant of a simulated world: implements the interface `robcl::World` with a SimulatedWorld.
/// Thread-safe. No handler waits.
class WorldServant final : public robcl::WorldServant {
 public:
  /// `catch_up` must move the held bodies to their present positions. Every handler that reads or
  /// moves bodies calls `catch_up` first. `clock_speed` is the speed of the LabClock.
  WorldServant(SimulatedWorld& world, std::function<void()> catch_up, double clock_speed = 1);

 private:
  gecos::Result<std::vector<robcl::Body>> bodies() override;
  gecos::Result<robcl::Body> find(const std::string& name) override;
  gecos::Result<robcl::RayHit> cast(const robcl::Frame& origin, double reach) override;
  gecos::Result<robcl::Contact> between(const robcl::Frame& jaws, double opening) override;
  gecos::Result<double> clock_speed() override { return clock_speed_; }
  gecos::Result<void> place(const std::string& name, const robcl::Frame& pose) override;

  robcl::UnknownBody unknown(const std::string& name) const;

  SimulatedWorld& world_;
  const std::function<void()> catch_up_;
  const double clock_speed_;
};

}  // namespace devices
