#pragma once

#include <concepts>
#include <string>

#include "devices/arm/manipulator_servant.hpp"
#include "robcl/articulated_arm_server.hpp"
#include "robcl/six_axis_server.hpp"

namespace devices {

/// Implements an interface that adds operations for the joints to `robcl::Manipulator`. Uses an
/// ArmDevice. `Interface` is the generated servant class of this interface, and `Joints` the type
/// in which the interface has joint positions. Thread-safe.
template <std::derived_from<robcl::ManipulatorServant> Interface, typename Joints>
class JointsServant : public virtual Interface, public ManipulatorServant {
 public:
  using ManipulatorServant::ManipulatorServant;

 protected:
  using Progress = ManipulatorServant::Progress;

  void publish_sample(const ArmDevice::Sample& sample) override;

  gecos::Result<Joints> joints() override;
  gecos::Result<Joints> commanded_joints() override;
  gecos::Result<void> move_joints(const Joints& target, const std::optional<robcl::Trajectory>& how,
                                  Progress& run) override;

 private:
  Joints sent_;  // keeps its memory from one sample to the next
};

extern template class JointsServant<robcl::SixAxisServant, robcl::Joints>;
extern template class JointsServant<robcl::ArticulatedArmServant, robcl::JointPositions>;

/// Implements `robcl::SixAxis`.
class SixAxisServant : public JointsServant<robcl::SixAxisServant, robcl::Joints> {
 public:
  /// Throws std::invalid_argument unless the arm has six joints.
  SixAxisServant(ArmDevice& arm, std::string place);
};

/// Implements `robcl::ArticulatedArm`.
class ArticulatedArmServant
    : public JointsServant<robcl::ArticulatedArmServant, robcl::JointPositions> {
 public:
  using JointsServant::JointsServant;
};

}  // namespace devices
