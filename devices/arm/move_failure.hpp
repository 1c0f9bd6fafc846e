// The reasons why an arm did not make or did not complete a motion.
#pragma once

#include <string>
#include <variant>

#include "devices/drivers/joint_driver.hpp"
#include "robcl/arm/failure.hpp"

namespace devices {

/// The failure of a motion that its MotionWatcher interrupted. The arm stands somewhere on its
/// path.
struct Interrupted {};
/// The failure of a motion or setting that the state of the arm, or the request itself, does not
/// allow.
struct Refused {
  std::string reason;
};
/// The failure of a sensor-guided motion whose corrections stopped. The arm stands.
struct CorrectionsStopped {};
using MoveFailure =
    std::variant<robcl::arm::OutOfReach, robcl::arm::JointLimit, robcl::arm::Singular, Interrupted,
                 CorrectionsStopped, Refused, DriverFault>;

std::string to_string(const MoveFailure& failure);
/// Returns whether the motion was refused before it began.
bool is_refusal(const MoveFailure& failure);
MoveFailure as_move_failure(const robcl::arm::Failure& failure);

}  // namespace devices
