#pragma once

#include <optional>
#include <string>

#include "devices/gripper/simulated_gripper.hpp"
#include "devices/support/carrier.hpp"
#include "gecos/reconnecting.hpp"
#include "robcl/gripper_server.hpp"
#include "robcl/world_client.hpp"

namespace devices {

/// The servant of a simulated gripper: implements the interface `robcl::Gripper` with a
/// SimulatedGripper. Asks the simulated world, an object with the interface `robcl::World`, which
/// body the jaws will touch. Thread-safe. Handlers wait for the answers of that object.
class GripperServant final : public robcl::GripperServant {
 public:
  /// `world` is the name of the simulated world. If the name is empty, the jaws never touch a body.
  GripperServant(gecos::Lab& lab, std::string name, std::string world, const std::string& carrier,
                 const robcl::Frame& base_from_grip_point,
                 const SimulatedGripper::Settings& settings);

  /// Moves the jaws for one cycle, which lasts `seconds`. Only one thread may call this method.
  void step(double seconds) { gripper_.step(seconds); }
  /// Sends a sample of the jaws' state, and reconnects to the carrier when needed. Only one thread
  /// may call this method.
  void publish();

 private:
  using Run = gecos::Execution<robcl::GripperState>;
  enum class WorldShows { Held, Released };

  gecos::Result<robcl::Frame> base() override { return mounting_.base(); }
  gecos::Result<std::string> parent() override { return mounting_.parent(); }
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& offset) override;
  gecos::Result<robcl::GripperState> jaws() override;
  gecos::Result<robcl::Frame> grip_point() override;
  gecos::Result<double> max_width() override { return gripper_.settings().max_width; }
  gecos::Result<double> max_force() override { return gripper_.settings().max_force; }
  gecos::Result<void> open(double width, Run& run) override;
  gecos::Result<void> close(double force, Run& run) override;

  gecos::Result<std::optional<SimulatedGripper::Contact>> contact();
  gecos::Result<void> let_jaws_move(Run& run);
  gecos::Result<void> wait_for_world(const std::string& body, WorldShows what, Run& run);

  const std::string name_;
  gecos::Reconnecting<robcl::World> world_;
  Mounting mounting_;
  const robcl::Frame base_from_grip_point_;
  SimulatedGripper gripper_;
};

}  // namespace devices
