#pragma once

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Computes the set points of a motion, one control cycle after the other. The functions neither
/// allocate memory nor wait.
class TrajectoryGenerator {
 public:
  virtual ~TrajectoryGenerator() = default;

  /// Returns the joint positions at which the motion starts from rest.
  virtual const JointValues& start() const = 0;
  /// Advances the time by `seconds` and returns the set points of the joints. Should not throw: an
  /// exception ends the motion as a fault.
  virtual JointValues advance(double seconds) = 0;
  /// Scales the speed of the motion in the following calls of `advance`. `factor` is from 0 to 1; 0
  /// pauses the motion. The path stays the same, and the limits of the arm are kept.
  virtual void set_override(double factor) = 0;
  /// Makes the following calls of `advance` decelerate until the arm stands.
  virtual void stop() = 0;
  /// Must be called when the joints have stopped because no set points were sent to them for some
  /// cycles. The following calls of `advance` then accelerate from rest. If `stop` was called
  /// before, the motion ends instead.
  virtual void rest() = 0;

  virtual bool standing() const = 0;
  virtual bool stopping() const = 0;
  /// Returns the part of the motion's duration that has passed, from 0 to 1.
  virtual double fraction() const = 0;
  /// Returns the remaining time until the arm stands, in s.
  virtual double remaining() const = 0;
};

}  // namespace robcl::motion
