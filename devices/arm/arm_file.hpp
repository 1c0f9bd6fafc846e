// Reads the description of an arm from a TOML file, and from a URDF file whose path is in the TOML
// file. docs/adding-an-arm.md lists the keys of the TOML file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "gecos/base/result.hpp"
#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/motion/pace.hpp"

namespace devices {

/// The description of an arm in its TOML file and its URDF file.
struct ArmDescription {
  std::string name;               ///< name under which clients find the arm
  std::string description;        ///< name of the arm for people, for example "Staeubli RX90"
  robcl::arm::ArmModel model;     ///< with the configuration that `front_deg` defines, if given
  robcl::arm::JointValues start;  ///< start positions of the simulated joints, rad
  robcl::motion::ToolLimits tool_limits;
  double seconds_to_full_acceleration = 0;  ///< limit of jerk (robcl::motion::Smoothing); 0: none
  robcl::Frame tool_offset;                 ///< tool frame seen from the flange
  /// A sentence that says where the arm stands. Error texts of `mount` begin with this sentence;
  /// see ManipulatorServant.
  std::string place;
};

/// A mistake in the files of an arm.
struct ArmFileError {
  std::string file;  ///< the TOML file
  /// The number of the line with the mistake, from 1. For a missing key, the line on which the
  /// table of the key begins; 0 if the file cannot be read.
  std::size_t line = 0;
  std::string key;   ///< for example "tool.offset_mm"; empty if the file is not TOML
  std::string text;  ///< the mistake, and how to mend it
};
/// Returns the error as a line of text, such as "rx90.toml:9: front_deg: …".
std::string to_string(const ArmFileError& error);

/// Returns the text of the URDF file `urdf`, or the reason why it cannot be read.
using ReadUrdf =
    std::function<tl::expected<std::string, std::string>(const std::filesystem::path& urdf)>;

/// Reads the description of an arm from `toml`, the text of a TOML file. `file` is the name of that
/// file, for errors. Calls `read_urdf` with the value of the key `urdf`, to get the text of the
/// URDF file.
tl::expected<ArmDescription, ArmFileError> parse_arm(const std::string& toml,
                                                     const std::string& file,
                                                     const ReadUrdf& read_urdf);

/// Reads the TOML file `file` and its URDF file.
tl::expected<ArmDescription, ArmFileError> read_arm(const std::filesystem::path& file);

/// The texts of the two files of an arm. The build compiles these texts into the program that
/// serves this arm; see Arm.cmake.
struct ArmFiles {
  const char* file;  ///< name of the TOML file
  const char* toml;  ///< its text
  const char* urdf;  ///< the text of the URDF file
};
tl::expected<ArmDescription, ArmFileError> parse_arm(const ArmFiles& files);

}  // namespace devices
