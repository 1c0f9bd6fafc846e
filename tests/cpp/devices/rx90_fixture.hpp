// An RX90 that is served, and whose control loop is the test's.
#pragma once

#include "devices/arm/joints_servant.hpp"
#include "devices/drivers/simulated_driver.hpp"
#include "devices/rx90/rx90_files.hpp"
#include "laboratory.hpp"
#include "robcl/frames/units.hpp"
#include "robcl/rx90_client.hpp"
#include "robcl/rx90_server.hpp"

namespace devices {

class Rx90Arm final : public robcl::Rx90Servant, public SixAxisServant {
 public:
  using devices::SixAxisServant::SixAxisServant;
};

class Rx90Laboratory : public Laboratory {
 protected:
  void SetUp() override {
    Laboratory::SetUp();
    serve("RX90", servant_);
    robot_ = create<robcl::Rx90>("RX90");
  }

  /// A cycle of its control loop.
  auto cycle() {
    return [this] {
      arm_.step(0.004);
      servant_.publish();
    };
  }

  /// Where the set points put the tool: they have no noise of the encoders.
  Frame commanded_tool() {
    robcl::arm::Kinematics forward(described_.model);
    return forward.base_from_flange(arm_.sample().commanded) * arm_.tool_offset();
  }

  const ArmDescription described_ = parse_arm(rx90_files).value();
  SimulatedDriver driver_{described_.start, {}};
  ArmDevice arm_{described_.model,
                 {.tool_limits = described_.tool_limits, .tool_offset = described_.tool_offset},
                 driver_};
  Rx90Arm servant_{arm_, described_.place};
  robcl::Rx90 robot_;
};

}  // namespace devices
