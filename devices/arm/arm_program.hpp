// The code of a server program for a six-axis arm. All six-axis arms use this code.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arm/six_axis_servant.hpp"

namespace devices {

/// The settings in which the program of one arm differs from the programs of other arms.
struct ArmProgram {
  std::string program;      ///< name of the program, for example "robcl-rx90"
  std::string name;         ///< name under which clients find the arm, unless --name is given
  std::string arm;          ///< name of the arm for people, for example "Staeubli RX90"
  std::string urdf;         ///< text of the URDF model
  std::string base_link;    ///< name of the base link in the URDF model
  std::string flange_link;  ///< name of the flange link in the URDF model
  /// Time in s in which a joint reaches its full speed. It determines the acceleration limits of
  /// the joints, because neither the URDF model nor a published source states them.
  double seconds_to_full_speed = 0.25;
  /// Joint positions at which the arm is righty, above and noflip; see Configuration. May be empty.
  std::vector<double> front_degrees{};
  std::vector<double> start_degrees;  ///< start positions of the simulated joints
  /// Tells where the arm stands. The text becomes the start of an error of `mount`; see
  /// ManipulatorServant.
  std::string place;
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

}  // namespace devices
