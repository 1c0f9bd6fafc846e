#pragma once

#include <string>

#include "gecos/base/mutex.hpp"
#include "robcl/gripper_client.hpp"
#include "support/carrier.hpp"
#include "world/simulated_world.hpp"

namespace devices {

/// Moves the body that a gripper holds: watches the gripper's jaws and the flange that carries the
/// gripper.
class GripperWatch {
 public:
  GripperWatch(gecos::Lab& lab, SimulatedWorld& world, std::string gripper);

  /// Connects if needed, reads the state of the jaws and moves the held body. Called by one thread;
  /// may block for up to 0.5 s while an object is not online.
  void tick();
  /// Moves the held body with the flange. Called by any thread; does not wait.
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
