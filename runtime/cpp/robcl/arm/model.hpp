// The model of an arm: its chain of joints, which is read from a URDF file, and the limits of the
// joints.
#pragma once

#include <filesystem>
#include <kdl/chain.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "robcl/arm/joint_values.hpp"

namespace robcl::arm {

struct ModelError {
  std::string text;
};

/// The model of an arm: a chain of revolute joints from a base link to a flange link. A model never
/// changes.
///
/// Threads must not share a chain, because const methods of KDL::Joint change a cache of the last
/// pose. A computation must therefore use a copy of the chain (see Kinematics).
class ArmModel {
 public:
  /// Makes a model from the text of a URDF file. URDF has no acceleration limits. Therefore each
  /// joint gets the acceleration with which it reaches its full speed in `seconds_to_full_speed`.
  static tl::expected<ArmModel, ModelError> from_urdf(const std::string& xml,
                                                      const std::string& base_link,
                                                      const std::string& flange_link,
                                                      double seconds_to_full_speed);
  static tl::expected<ArmModel, ModelError> from_urdf_file(const std::filesystem::path& file,
                                                           const std::string& base_link,
                                                           const std::string& flange_link,
                                                           double seconds_to_full_speed);

  /// Returns this model with the joint positions `front`, in rad, at which the arm is righty, above
  /// and noflip by definition (see Configuration). Fails if `front` is not inside the limits.
  tl::expected<ArmModel, ModelError> with_front(const JointValues& front) const;

  /// Returns this model with joints that reach their full speed in `seconds`, a time above 0 for
  /// each joint. @pre `seconds` has a value for each joint.
  ArmModel with_seconds_to_full_speed(const std::vector<double>& seconds) const;

  /// Returns this model with limits of travel that are widened, where necessary, so that the joint
  /// positions `joints`, in rad, are inside them.
  ArmModel with_travel_to(const JointValues& joints) const;

  const std::string& name() const { return name_; }
  Eigen::Index axes() const { return static_cast<Eigen::Index>(limits_.size()); }
  const KDL::Chain& chain() const { return chain_; }
  const std::vector<JointLimits>& limits() const { return limits_; }
  const std::vector<std::string>& joint_names() const { return joint_names_; }
  const std::optional<JointValues>& front() const { return front_; }

  /// Returns an upper limit of the distance of the flange from the base, in m.
  double reach() const { return reach_; }

 private:
  ArmModel() = default;

  std::string name_;
  KDL::Chain chain_;
  std::vector<JointLimits> limits_;
  std::vector<std::string> joint_names_;
  double reach_ = 0;
  std::optional<JointValues> front_;
};

}  // namespace robcl::arm
