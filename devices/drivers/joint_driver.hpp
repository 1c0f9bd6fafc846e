// The interface between motion and hardware: the drives of one arm.
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

/// Which value of a JointCommand the drives must follow. The other values may serve as
/// feed-forward.
enum class ControlMode { Position, Velocity, Torque };

enum class DrivePower {
  Off,        ///< no torque; the brakes hold
  TurningOn,  ///< enabled, but not ready yet
  On,         ///< follows commands
  Fault,      ///< no torque and the brakes hold, until `reset`
};

/// State of the joints' brakes. For joints without brakes it is Released.
enum class Brakes { Engaged, Released };

/// The set points of the joints until the next command.
struct JointCommand {
  JointValues position;  ///< rad, at the end of the cycle
  JointValues velocity;  ///< rad/s
  JointValues torque;    ///< N·m; empty unless the mode is Torque
};

/// Measurements and state of the drives.
struct JointState {
  DrivePower power = DrivePower::Off;
  Brakes brakes = Brakes::Engaged;
  ControlMode mode = ControlMode::Position;  ///< valid once the drives were enabled
  JointValues position;                      ///< rad
  JointValues velocity;                      ///< rad/s; empty: not measured
  JointValues torque;                        ///< N·m; empty: not measured
  std::int64_t measured_at_ns = 0;           ///< time of this host's Unix clock
  std::string fault;                         ///< text for people if power is Fault
};

/// The joints of one arm. Used by one thread at a time.
///
/// Every function must return within a fraction of the control cycle. Longer work, such as
/// releasing the brakes, must continue in the background while `exchange` reports TurningOn. A
/// driver that fails, throws or returns impossible values ends the motion with a fault (see
/// SupervisedDriver).
class JointDriver {
 public:
  struct Capabilities {
    Eigen::Index axes = 0;
    bool position = false, velocity = false, torque = false;  ///< supported control modes
    /// Time without an `exchange`, s, after which the drives stop by themselves. If the control
    /// loop stalled for longer than this time, the motion fails.
    double longest_gap = std::numeric_limits<double>::infinity();
  };

  virtual ~JointDriver() = default;

  virtual Capabilities capabilities() const = 0;

  /// Reads the measured state; sends no command to the drives.
  virtual tl::expected<JointState, DriverFault> read() = 0;
  /// Turns the drives on and releases the brakes. The joints stay where they are until the first
  /// `exchange` that finds them On. Fails in a mode that the drives do not have, and while a fault
  /// is not reset.
  virtual tl::expected<void, DriverFault> enable(ControlMode mode) = 0;
  /// Stops the joints, engages the brakes, turns the drives off.
  virtual tl::expected<void, DriverFault> disable() = 0;
  /// Clears a fault whose cause is gone. Afterwards the drives are Off.
  virtual tl::expected<void, DriverFault> reset() = 0;

  /// Called once per control cycle: takes the command for the next `seconds` and returns
  /// measurements. Ignores the command unless the drives are On. Allocates only on failure.
  virtual tl::expected<JointState, DriverFault> exchange(const JointCommand& command,
                                                         double seconds) = 0;
};

}  // namespace devices
