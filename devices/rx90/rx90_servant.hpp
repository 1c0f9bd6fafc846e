#pragma once

#include "kdl/kdl_manipulator.hpp"
#include "robcl/rx90_server.hpp"

namespace devices {

/// A KdlSixAxis as the object `robcl::Rx90`. Thread-safe.
class Rx90Servant final : public robcl::Rx90Servant {
 public:
  explicit Rx90Servant(KdlSixAxis& arm) : arm_(arm) {}

  /// Sends a sample of every stream if something was measured since the last. One thread at a time.
  void publish();

 private:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  gecos::Result<Frame> base() override { return arm_.base(); }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string& carrier, const Frame& offset) override;
  gecos::Result<Frame> tool() override { return arm_.tool(); }
  gecos::Result<Frame> flange() override { return arm_.flange(); }
  gecos::Result<Frame> tool_offset() override { return arm_.tool_offset(); }
  gecos::Result<void> set_tool_offset(const Frame& value) override;
  gecos::Result<void> move(const Frame& goal, const std::optional<robcl::Trajectory>& how,
                           Progress& run) override;
  gecos::Result<robcl::Joints> joints() override;
  gecos::Result<void> move_joints(const robcl::Joints& target,
                                  const std::optional<robcl::Trajectory>& how,
                                  Progress& run) override;
  gecos::Result<robcl::Configuration> posture() override;

  KdlSixAxis& arm_;
  std::uint64_t published_ = 0;  // the cycle
};

}  // namespace devices
