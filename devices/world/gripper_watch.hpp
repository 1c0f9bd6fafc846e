#pragma once

#include <string>

#include "devices/support/carrier.hpp"
#include "devices/world/simulated_world.hpp"
#include "gecos/base/mutex.hpp"
#include "robcl/gripper_client.hpp"

namespace devices {

/// Moves the body that a gripper holds in the simulated world. Reads the streams of the gripper's
/// jaws and of the flange that carries the gripper.
class GripperWatch {
 public:
  GripperWatch(gecos::Lab& lab, SimulatedWorld& world, std::string gripper);

  /// Connects to the streams if needed, reads the state of the jaws and moves the held body. Only
  /// one thread may call this method. May block for up to 0.5 s while an object is not online.
  void tick();
  /// Moves the held body to where the flange is now. Does not wait. Any thread may call this
  /// method.
  void carry();

 private:
  void see(const robcl::GripperState& jaws);

  SimulatedWorld& world_;
  const std::string name_;
  Carrier carrier_;
  gecos::ReconnectingStream<robcl::Gripper, robcl::GripperState> jaws_;

  gecos::Mutex guard_;
  std::string held_ GECOS_GUARDED_BY(guard_);  // the held body, as last reported to the world
};

}  // namespace devices
