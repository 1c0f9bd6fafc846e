// The `main` of a program that serves an arm.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "devices/arm/arm_file.hpp"
#include "devices/arm/joints_servant.hpp"

namespace devices {

/// The settings of the program that serves one arm.
struct ArmProgram {
  std::string program;  ///< name of the program, for example "robcl-rx90"
  /// The files that describe the arm. Without a value, the first argument on the command line is
  /// the TOML file of the arm.
  std::optional<ArmFiles> files{};
  /// Makes the driver of the real joints of `arm`. If this function is empty, the program simulates
  /// the joints. An exception of this function ends the program, which prints the text of the
  /// exception.
  std::function<std::unique_ptr<JointDriver>(const ArmDescription& arm)> connect{};
};

/// A function that makes the servant of an arm. `place` is a sentence that says where the arm
/// stands; see ManipulatorServant.
using MakeServant =
    std::function<std::unique_ptr<ManipulatorServant>(ArmDevice& arm, std::string place)>;

/// Serves the arm until the program gets SIGINT or SIGTERM. Returns the program's exit status.
int serve_arm(const ArmProgram& program, const MakeServant& make_servant, int count, char** words);

/// Serves an arm that has no interface of its own. The object has the interface SixAxis if the arm
/// has six joints, otherwise the interface ArticulatedArm.
int serve_arm(const ArmProgram& program, int count, char** words);

/// Serves an arm with an interface of its own, which `Servant` implements.
template <std::derived_from<ManipulatorServant> Servant>
int serve_arm(const ArmProgram& program, int count, char** words) {
  const MakeServant make = [](ArmDevice& arm, std::string place) {
    return std::make_unique<Servant>(arm, std::move(place));
  };
  return serve_arm(program, make, count, words);
}

}  // namespace devices
