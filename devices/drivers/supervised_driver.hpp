#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "drivers/joint_driver.hpp"

namespace devices {

/// A driver whose answers can be trusted to be possible. Whatever `driver` throws, and whatever it
/// says that cannot be true, is a DriverFault here: numbers that are none, or not as many as the
/// arm has joints; a stamp of the future, or one that stays old; a joint that moved faster than it
/// can.
class SupervisedDriver final : public JointDriver {
 public:
  /// s. An older measurement counts as no answer, and so does one that is as far in the future.
  static constexpr double oldest = 0.1;
  /// Times its greatest speed at which a joint is not believed to have moved.
  static constexpr double speed_margin = 4;

  /// `limits`: one per joint.
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
  JointValues last_;  // position; empty after a fault, when nothing says how far a joint may be
};

}  // namespace devices
