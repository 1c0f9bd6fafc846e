// Model of an arm: its chain of joints from a URDF file, and their limits.
#pragma once

#include <filesystem>
#include <kdl/chain.hpp>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "robcl/arm/joint_values.hpp"

namespace robcl::arm {

struct ModelError {
  std::string text;
};

/// A chain of revolute joints from a base link to a flange link. Immutable.
///
/// KDL::Joint caches its last pose inside const methods, so a chain must not be shared between
/// threads: a computation takes a copy (see Kinematics).
class ArmModel {
 public:
  /// URDF has no acceleration limits: each joint gets the acceleration with which it reaches its
  /// full speed in `seconds_to_full_speed`.
  static tl::expected<ArmModel, ModelError> from_urdf(const std::string& xml,
                                                      const std::string& base_link,
                                                      const std::string& flange_link,
                                                      double seconds_to_full_speed);
  static tl::expected<ArmModel, ModelError> from_urdf_file(const std::filesystem::path& file,
                                                           const std::string& base_link,
                                                           const std::string& flange_link,
                                                           double seconds_to_full_speed);

  const std::string& name() const { return name_; }
  Eigen::Index axes() const { return static_cast<Eigen::Index>(limits_.size()); }
  const KDL::Chain& chain() const { return chain_; }
  const std::vector<JointLimits>& limits() const { return limits_; }
  const std::vector<std::string>& joint_names() const { return joint_names_; }

  /// Upper bound of the flange's distance from the base, m.
  double reach() const { return reach_; }

 private:
  ArmModel() = default;

  std::string name_;
  KDL::Chain chain_;
  std::vector<JointLimits> limits_;
  std::vector<std::string> joint_names_;
  double reach_ = 0;
};

}  // namespace robcl::arm
