// The limit of jerk.
#pragma once

#include <cstddef>

#include "robcl/motion/bounds.hpp"

namespace robcl::motion {

/// Limits the jerk of a motion. The place s of a set point on the path is a moving average: the
/// mean of the last places of the time law, over a window of some control cycles. The path stays
/// the same. The jerk d³s/dt³ of the set points is the change of d²s/dt² over the window, divided
/// by the length of the window. If the limits are constant, the mean of a trapezoid of the speed is
/// the fastest motion with a limit of jerk; cf. L. Biagiotti and C. Melchiorri, "FIR filters for
/// online trajectory planning with time- and frequency-domain specifications", 2012.
struct Smoothing {
  std::size_t cycles = 1;  ///< set points in the window; one if there is no limit of jerk
  double window = 0;       ///< length of the window in s
  double rise = 0;         ///< time in s in which an acceleration may rise from 0 to its limit

  /// Returns the limit of jerk with which an acceleration rises from 0 to its own limit in `rise`
  /// seconds, for set points that are `cycle` seconds apart. There is no limit of jerk if `rise` is
  /// not longer than `cycle`.
  static Smoothing over(double rise, double cycle);

  bool on() const { return cycles > 1; }
  /// Returns the greatest change of d²s/dt² within the window, at a place where the limit of
  /// d²s/dt² is `limit`.
  double change(double limit) const { return on() ? limit * window / rise : infinite; }
};

}  // namespace robcl::motion
