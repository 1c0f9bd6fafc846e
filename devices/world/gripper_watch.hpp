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

  /// Connects where needed, sees what the jaws do, moves what they carry. One thread; may wait for
  /// up to half a second while something is not there.
  void tick();
  /// Moves what they carry to where it is now. Any thread; does not wait.
  void carry();

 private:
  void see(const robcl::GripperState& jaws);

  SimulatedWorld& world_;
  const std::string name_;
  Carrier carrier_;
  gecos::ReconnectingStream<robcl::Gripper, robcl::GripperState> jaws_;

  gecos::Mutex guard_;
  std::string held_ GECOS_GUARDED_BY(guard_);  // what the world was told that the gripper holds
};

}  // namespace devices
