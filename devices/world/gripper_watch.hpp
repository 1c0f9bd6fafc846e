#pragma once

#include <string>

#include "gecos/base/mutex.hpp"
#include "robcl/gripper_client.hpp"
#include "support/carrier.hpp"
#include "world/simulated_world.hpp"

namespace devices {

/// Lets a body follow one gripper: watches its jaws, and the flange that carries it.
class GripperWatch {
 public:
  GripperWatch(gecos::Lab& lab, SimulatedWorld& world, std::string gripper);

  /// Connects where needed, reads the state of the jaws, and moves the body they carry. One thread;
  /// may block for up to 0.5 s while an object is not online.
  void tick();
  /// Moves the carried body to its present place. Any thread; does not wait.
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
