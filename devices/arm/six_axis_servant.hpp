#pragma once

#include <string>
#include <utility>

#include "arm/manipulator_servant.hpp"
#include "robcl/six_axis_server.hpp"

namespace devices {

/// Implements the operations of the interface `robcl::SixAxis` with a SixAxisDevice. Thread-safe.
class SixAxisServant : public virtual robcl::SixAxisServant, public ManipulatorServant {
 public:
  SixAxisServant(SixAxisDevice& arm, std::string place)
      : ManipulatorServant(arm, std::move(place)), arm_(arm) {}

 protected:
  using Progress = ManipulatorServant::Progress;

  void publish_sample(const ArmDevice::Sample& sample) override;

  gecos::Result<robcl::Joints> joints() override;
  gecos::Result<robcl::Joints> commanded_joints() override;
  gecos::Result<void> move_joints(const robcl::Joints& target,
                                  const std::optional<robcl::Trajectory>& how,
                                  Progress& run) override;

 private:
  SixAxisDevice& arm_;
};

/// The servant of an arm whose interface adds no operation to SixAxis. `Skeleton` is the generated
/// servant class of that interface. Derive from ExactArm to implement additional operations.
template <class Skeleton>
class ExactArm : public Skeleton, public SixAxisServant {
 public:
  using SixAxisServant::SixAxisServant;
};

}  // namespace devices
