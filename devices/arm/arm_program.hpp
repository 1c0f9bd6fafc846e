// The server program that all six-axis arms share.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arm/six_axis_servant.hpp"

namespace devices {

/// The differences between the programs of two arms.
struct ArmProgram {
  std::string program;      ///< "robcl-rx90"
  std::string name;         ///< registered, unless --name is given
  std::string arm;          ///< for people: "Staeubli RX90"
  std::string urdf;         ///< the model itself
  std::string base_link;    ///< in the URDF
  std::string flange_link;  ///< in the URDF
  /// Sets the acceleration limit of each joint: neither URDF nor a published source has one.
  double seconds_to_full_speed = 0.25;
  std::vector<double> start_degrees;  ///< where the joints of the simulated arm stand at first
  std::string place;                  ///< why the arm has no carrier; see ManipulatorServant
  /// Makes the driver of the real joints. Empty: they are simulated.
  std::function<std::unique_ptr<JointDriver>()> connect{};
};

using MakeServant = std::function<std::unique_ptr<SixAxisServant>(SixAxisDevice&, std::string)>;

/// Serves the arm until SIGINT or SIGTERM. Gives the program's exit status.
int serve_arm(const ArmProgram& arm, const MakeServant& make_servant, int count, char** words);

/// As above; `Skeleton` is what gidl generates for the arm's interface.
template <class Skeleton>
int serve_arm(const ArmProgram& arm, int count, char** words) {
  const MakeServant make = [](SixAxisDevice& device, std::string place) {
    return std::make_unique<ExactArm<Skeleton>>(device, std::move(place));
  };
  return serve_arm(arm, make, count, words);
}

}  // namespace devices
