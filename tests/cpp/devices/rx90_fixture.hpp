// An RX90 that is served, and whose control loop is the test's.
#pragma once

#include "arm/six_axis_servant.hpp"
#include "drivers/simulated_driver.hpp"
#include "laboratory.hpp"
#include "robcl/frames/units.hpp"
#include "robcl/rx90_client.hpp"
#include "robcl/rx90_server.hpp"
#include "rx90/rx90_urdf.hpp"

namespace devices {

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

  static JointValues ready() {
    JointValues joints(6);
    joints << 0, robcl::deg(-20), robcl::deg(110), 0, robcl::deg(90), 0;
    return joints;
  }

  static JointValues front() {
    JointValues joints = ready();
    joints[4] = robcl::deg(-45);
    return joints;
  }

  SimulatedDriver driver_{ready(), {}};
  SixAxisDevice arm_{robcl::arm::ArmModel::from_urdf(rx90_urdf, "foot", "flange", 0.25)
                         .value()
                         .with_front(front())
                         .value(),
                     {.tool_offset = robcl::translate(0, 0, robcl::mm(150))},
                     driver_};
  ExactArm<robcl::Rx90Servant> servant_{arm_, "an RX90 weighs 111 kg and stands on the floor"};
  robcl::Rx90 robot_;
};

}  // namespace devices
