#pragma once

#include "robcl/frames/frame.hpp"
#include "robcl/motion/pace.hpp"

namespace robcl::motion {

/// A tool frame that moves towards a target in each control cycle, within limits of speed and
/// acceleration. The target may change in each cycle. A value type that never allocates memory.
struct ToolLead {
  Frame pose;                                            ///< seen from the base
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();       ///< m/s, in the last cycle
  Eigen::Vector3d turn_speed = Eigen::Vector3d::Zero();  ///< rad/s, in the last cycle

  /// Returns the state after the next cycle of `cycle` seconds, on the way to `target`. The tool
  /// frame reaches a target that stands still. It does not overshoot if it already moves straight
  /// towards the target.
  ToolLead towards(const Frame& target, const ToolLimits& limits, double cycle) const;
  /// Returns the state after the next cycle if the tool frame brakes.
  ToolLead braking(const ToolLimits& limits, double cycle) const;
  /// Returns the pose at which the tool frame comes to rest if it brakes in all following cycles.
  Frame stop(const ToolLimits& limits, double cycle) const;
  /// Returns whether the tool frame has reached `target`, up to rounding errors.
  bool is_at(const Frame& target) const;
  bool at_rest() const { return speed.isZero(0) && turn_speed.isZero(0); }

 private:
  ToolLead moved(const Eigen::Vector3d& new_speed, const Eigen::Vector3d& new_turn_speed,
                 double cycle) const;
};

}  // namespace robcl::motion
