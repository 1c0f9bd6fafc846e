// The code of the server programs for arms. All arms use this code.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "arm/arm_file.hpp"
#include "arm/six_axis_servant.hpp"

namespace devices {

/// The settings in which the program of one six-axis arm differs from the programs of other arms.
struct ArmProgram {
  std::string program;  ///< name of the program, for example "robcl-rx90"
  ArmFiles files;       ///< the description of the arm
  /// Makes the driver of the real joints. If this function is empty, the program simulates the
  /// joints.
  std::function<std::unique_ptr<JointDriver>()> connect{};
};

using MakeServant = std::function<std::unique_ptr<SixAxisServant>(SixAxisDevice&, std::string)>;

/// Serves the arm until the program gets SIGINT or SIGTERM. Returns the program's exit status.
int serve_arm(const ArmProgram& arm, const MakeServant& make_servant, int count, char** words);

/// Serves an arm whose interface adds no operation to SixAxis. `Skeleton` is the generated servant
/// class of that interface.
template <class Skeleton>
int serve_arm(const ArmProgram& arm, int count, char** words) {
  const MakeServant make = [](SixAxisDevice& device, std::string place) {
    return std::make_unique<ExactArm<Skeleton>>(device, std::move(place));
  };
  return serve_arm(arm, make, count, words);
}

/// The program robcl-arm: serves the arm of the TOML file that its first argument names, with
/// simulated joints. An arm of six joints has the interface SixAxis, any other one Manipulator.
int serve_arm_of_file(int count, char** words);

}  // namespace devices
