#pragma once

#include <string>
#include <utility>

#include "arm/manipulator_servant.hpp"
#include "robcl/six_axis_server.hpp"

namespace devices {

/// The operations of `robcl::SixAxis` over an arm with six joints. Thread-safe.
class SixAxisServant : public virtual robcl::SixAxisServant, public ManipulatorServant {
 public:
  SixAxisServant(SixAxisDevice& arm, std::string place)
      : ManipulatorServant(arm, std::move(place)), arm_(arm) {}

 protected:
  using Progress = ManipulatorServant::Progress;

  void publish_sample(const ArmDevice::Sample& sample) override;

  gecos::Result<robcl::Joints> joints() override;
  gecos::Result<void> move_joints(const robcl::Joints& target,
                                  const std::optional<robcl::Trajectory>& how,
                                  Progress& run) override;

 private:
  SixAxisDevice& arm_;
};

/// An arm whose interface adds nothing to SixAxis but its name: `Skeleton` is what gidl generates
/// for it. An interface with operations of its own derives from this and implements them.
template <class Skeleton>
class ExactArm : public Skeleton, public SixAxisServant {
 public:
  using SixAxisServant::SixAxisServant;
};

}  // namespace devices
