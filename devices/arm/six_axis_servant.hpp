#pragma once

#include <string>

#include "devices/arm/manipulator_servant.hpp"
#include "robcl/six_axis_server.hpp"

namespace devices {

/// Implements the operations of the interface `robcl::SixAxis` with an ArmDevice of six joints.
/// Thread-safe.
class SixAxisServant : public virtual robcl::SixAxisServant, public ManipulatorServant {
 public:
  /// Throws std::invalid_argument if the arm has another number of joints.
  SixAxisServant(ArmDevice& arm, std::string place);

 protected:
  using Progress = ManipulatorServant::Progress;

  void publish_sample(const ArmDevice::Sample& sample) override;

  gecos::Result<robcl::Joints> joints() override;
  gecos::Result<robcl::Joints> commanded_joints() override;
  gecos::Result<void> move_joints(const robcl::Joints& target,
                                  const std::optional<robcl::Trajectory>& how,
                                  Progress& run) override;
};

}  // namespace devices
