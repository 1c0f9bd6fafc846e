// The path parameter s over time.
#pragma once

#include <vector>

#include "robcl/motion/bounds.hpp"

namespace robcl::motion {

/// A time law from rest to rest, with constant d²s/dt² between knots.
class TimeLaw {
 public:
  struct State {
    double s = 0;
    double speed = 0;         ///< ds/dt, 1/s
    double acceleration = 0;  ///< d²s/dt², 1/s²
  };

  /// The fastest law that keeps all bounds. A backward pass finds the greatest speed at each knot
  /// from which the arm can still stop at the end; a forward pass accelerates as hard as these
  /// speeds allow (H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization
  /// Based on Reachability Analysis", 2018). If only the tool's limits apply, the speed profile is
  /// a trapezoid.
  static TimeLaw fastest(const PathBounds& bounds);
  /// The time law of a path without length.
  static TimeLaw standing();

  /// This law slowed by `factor`, which multiplies all times.
  TimeLaw slowed(double factor) const;

  double duration() const { return times_.back(); }
  /// The state at a time: before 0 the start, after `duration()` the end. Never allocates.
  State at(double seconds) const;
  /// ds/dt of this law at `s`, 1/s.
  double speed_at(double s) const;

 private:
  explicit TimeLaw(const std::vector<double>& squared_speeds);

  std::vector<double> times_;   // time at each knot, s
  std::vector<double> speeds_;  // ds/dt at each knot, 1/s
};

}  // namespace robcl::motion
