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
  std::string name;         ///< name to register unless --name is given
  std::string arm;          ///< in texts for people: "Staeubli RX90"
  std::string urdf;         ///< text of the URDF model
  std::string base_link;    ///< name of the base link in the URDF model
  std::string flange_link;  ///< name of the flange link in the URDF model
  /// The acceleration limit of a joint is its full speed divided by this time, because neither URDF
  /// nor a published source has such a limit.
  double seconds_to_full_speed = 0.25;
  std::vector<double> start_degrees;  ///< start positions of the simulated joints
  /// Where the arm stands, for the error of `mount`; see ManipulatorServant.
  std::string place;
  /// Makes the driver of the real joints. If empty, the joints are simulated.
  std::function<std::unique_ptr<JointDriver>()> connect{};
};

using MakeServant = std::function<std::unique_ptr<SixAxisServant>(SixAxisDevice&, std::string)>;

/// Serves the arm until SIGINT or SIGTERM. Returns the program's exit status.
int serve_arm(const ArmProgram& arm, const MakeServant& make_servant, int count, char** words);

/// Serves an arm whose generated servant class is `Skeleton`, which adds no operation to SixAxis.
template <class Skeleton>
int serve_arm(const ArmProgram& arm, int count, char** words) {
  const MakeServant make = [](SixAxisDevice& device, std::string place) {
    return std::make_unique<ExactArm<Skeleton>>(device, std::move(place));
  };
  return serve_arm(arm, make, count, words);
}

}  // namespace devices
