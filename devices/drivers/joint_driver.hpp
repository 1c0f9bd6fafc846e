// The interface of the drives of one arm, which separates the motion code from the hardware.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "gecos/base/result.hpp"
#include "robcl/arm/joint_values.hpp"

namespace devices {

using robcl::arm::JointValues;

/// A malfunction of the drive electronics or of the connection to them.
struct DriverFault {
  std::string text;
};

/// The member of a JointCommand that the drives follow. A driver may use the other member as
/// feed-forward.
enum class ControlMode { Position, Velocity };

enum class DrivePower {
  Off,        ///< no torque; the brakes hold
  TurningOn,  ///< enabled, but not ready yet
  On,         ///< follows commands
  Fault,      ///< no torque; the brakes hold until `reset` is called
};

/// State of the joints' brakes. Joints without brakes are always Released.
enum class Brakes { Engaged, Released };

/// The set points that the joints follow until the next command.
struct JointCommand {
  JointValues position;  ///< rad, at the end of the cycle
  JointValues velocity;  ///< rad/s
};

/// Measurements and state of the drives.
struct JointState {
  DrivePower power = DrivePower::Off;
  Brakes brakes = Brakes::Released;
  JointValues position{};           ///< rad
  JointValues velocity{};           ///< rad/s; empty: not measured
  std::int64_t measured_at_ns = 0;  ///< time of this host's Unix clock; 0: when `read` returned
  std::string fault{};              ///< text for people if power is Fault
};

/// The driver of the joints of one arm. Only one thread at a time may use a driver.
///
/// The control loop calls `write` and then `read` once per cycle. Each function must return within
/// a fraction of the cycle. Longer work, such as releasing the brakes, must continue in the
/// background while `read` reports TurningOn. If a driver fails, throws or returns impossible
/// values, the motion ends with a fault (see SupervisedDriver).
class JointDriver {
 public:
  struct Properties {
    /// Which set points the drives follow. In Velocity mode, the control loop of the arm's server
    /// controls the joint positions.
    ControlMode mode = ControlMode::Position;
    double period = 0.004;  ///< s, of the control loop
    /// Time in s without a call of `write` after which the drives stop by themselves. If the
    /// control loop stalls for longer than this time, the motion fails.
    double longest_gap = std::numeric_limits<double>::infinity();
  };

  virtual ~JointDriver() = default;

  virtual Properties properties() const { return {}; }

  /// Returns the measured state of the joints. Sends no command to the drives. Allocates memory
  /// only when it fails.
  virtual tl::expected<JointState, DriverFault> read() = 0;
  /// Sends `command` to the drives: the joints reach the positions of `command`, and have its
  /// velocities, at the end of the coming period. `since_last` is the time in s since the previous
  /// call: one period, or a multiple of it after missed cycles. Does nothing unless the drives are
  /// On. Allocates memory only when it fails.
  virtual tl::expected<void, DriverFault> write(const JointCommand& command, double since_last) = 0;

  /// Turns the drives on and releases the brakes. The joints stay where they are until the first
  /// call of `write` at which the drives are On. Fails if the drives have a fault that `reset` has
  /// not cleared.
  virtual tl::expected<void, DriverFault> enable() = 0;
  /// Stops the joints, engages the brakes and turns the drives off.
  virtual tl::expected<void, DriverFault> disable() = 0;
  /// Clears a fault of the drives after its cause has disappeared. The drives are then Off.
  virtual tl::expected<void, DriverFault> reset() = 0;
};

}  // namespace devices
