#pragma once

#include <string>

#include "arm/arm_device.hpp"
#include "robcl/manipulator_server.hpp"

namespace devices {

/// Implements the operations of `robcl::Manipulator` with an ArmDevice. Thread-safe.
///
/// The servant of a particular arm derives from this class and from the generated servant class of
/// its own interface (see ExactArm).
class ManipulatorServant : public virtual robcl::ManipulatorServant {
 public:
  /// `place` says where the arm stands: "an RX90 weighs 111 kg and stands on the floor". If `mount`
  /// is called with a carrier, the error begins with `place`.
  ManipulatorServant(ArmDevice& arm, std::string place) : arm_(arm), place_(std::move(place)) {}

  /// Sends a sample of every stream if there is a new measurement. Called by one thread at a time.
  void publish();

 protected:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  /// Sends `sample` on the streams of this interface. If an interface adds streams, its
  /// servant overrides this method and also calls it.
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
  std::uint64_t published_ = 0;  // number of the last published measurement
};

}  // namespace devices
