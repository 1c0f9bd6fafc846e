#pragma once

#include <string>

#include "arm/arm_device.hpp"
#include "robcl/manipulator_server.hpp"

namespace devices {

/// The operations of `robcl::Manipulator` over an arm. Thread-safe.
///
/// An exact arm inherits them beside the skeleton of its own interface (see ExactArm).
class ManipulatorServant : public virtual robcl::ManipulatorServant {
 public:
  /// `place` says where this arm stands, for the refusal of another carrier: "an RX90 weighs 111 kg
  /// and stands on the floor".
  ManipulatorServant(ArmDevice& arm, std::string place) : arm_(arm), place_(std::move(place)) {}

  /// Sends a sample of every stream if there is a new measurement. One thread at a time.
  void publish();

 protected:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  /// Sends `sample` on the streams of this interface. Interfaces that add streams call this, too.
  virtual void publish_sample(const ArmDevice::Sample& sample);

  gecos::Result<Frame> base() override { return arm_.base(); }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string& carrier, const Frame& offset) override;
  gecos::Result<Frame> tool() override { return arm_.tool(); }
  gecos::Result<Frame> flange() override { return arm_.flange(); }
  gecos::Result<robcl::Configuration> posture() override;
  gecos::Result<Frame> tool_offset() override { return arm_.tool_offset(); }
  gecos::Result<void> set_tool_offset(const Frame& value) override;
  gecos::Result<void> move(const Frame& goal, const std::optional<robcl::Trajectory>& how,
                           Progress& run) override;

 private:
  ArmDevice& arm_;
  const std::string place_;
  std::uint64_t published_ = 0;  // the last published cycle
};

}  // namespace devices
