#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "devices/drivers/joint_driver.hpp"

namespace devices {

/// Calls another driver and passes on only its plausible answers. Returns a DriverFault instead
/// when the other driver throws an exception or gives an impossible answer: a number that is NaN or
/// infinite, a wrong number of joints, a time stamp that is too old or in the future, or a joint
/// that moved faster than it can.
class SupervisedDriver {
 public:
  /// Greatest allowed age of a measurement, in s. An older measurement is a fault, and so is a
  /// measurement whose time stamp is more than this time in the future.
  static constexpr double oldest = 0.1;
  /// A measured movement of a joint is a fault if its speed is more than this multiple of the
  /// joint's speed limit.
  static constexpr double speed_margin = 4;

  /// @pre `limits` has one entry for each joint. `driver` must outlive this object.
  SupervisedDriver(JointDriver& driver, std::vector<robcl::arm::JointLimits> limits)
      : driver_(driver), limits_(std::move(limits)) {}

  tl::expected<JointState, DriverFault> read();
  tl::expected<void, DriverFault> enable();
  tl::expected<void, DriverFault> disable();
  tl::expected<void, DriverFault> reset();
  /// Writes the command for the coming period, and reads the state of the joints. `since_last` is
  /// the time in s since the previous call.
  tl::expected<JointState, DriverFault> exchange(const JointCommand& command, double since_last);

 private:
  /// `now`: the time at which the driver answered, in ns of the Unix clock.
  std::optional<DriverFault> lie_of(const JointState& state, std::int64_t now,
                                    double seconds) const;
  std::optional<DriverFault> jump_of(const JointValues& position, double seconds) const;
  tl::expected<JointState, DriverFault> read_judged(double seconds);

  JointDriver& driver_;
  const std::vector<robcl::arm::JointLimits> limits_;
  JointValues last_;  // last positions; empty after a fault, when a joint may have moved far
};

}  // namespace devices
