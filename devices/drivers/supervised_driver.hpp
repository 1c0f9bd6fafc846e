#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "drivers/joint_driver.hpp"

namespace devices {

/// A driver that returns only plausible answers. It turns every exception of `driver` and every
/// impossible answer into a DriverFault: NaN or infinite numbers, a wrong number of joints, a time
/// stamp in the future or too old, a joint that moved faster than it can.
class SupervisedDriver final : public JointDriver {
 public:
  /// Greatest age of a measurement, s. A measurement that is older, or this far in the future, is a
  /// fault.
  static constexpr double oldest = 0.1;
  /// A measured movement is a fault if it is faster than this multiple of the joint's speed limit.
  static constexpr double speed_margin = 4;

  /// `limits` has one entry per joint.
  SupervisedDriver(JointDriver& driver, std::vector<robcl::arm::JointLimits> limits)
      : driver_(driver), limits_(std::move(limits)) {}

  Capabilities capabilities() const override { return driver_.capabilities(); }
  tl::expected<JointState, DriverFault> read() override;
  tl::expected<void, DriverFault> enable(ControlMode mode) override;
  tl::expected<void, DriverFault> disable() override;
  tl::expected<void, DriverFault> reset() override;
  tl::expected<JointState, DriverFault> exchange(const JointCommand& command,
                                                 double seconds) override;

 private:
  std::optional<DriverFault> lie_of(const JointState& state, double seconds) const;
  std::optional<DriverFault> jump_of(const JointValues& position, double seconds) const;
  tl::expected<JointState, DriverFault> judged(tl::expected<JointState, DriverFault> answer,
                                               double seconds);

  JointDriver& driver_;
  const std::vector<robcl::arm::JointLimits> limits_;
  JointValues last_;  // last positions; empty after a fault: joints may have moved any distance
};

}  // namespace devices
