// When a path is where: s over time.
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

  /// The fastest law that keeps all bounds: a backward pass finds how fast each knot may be passed
  /// so that the end can still be met standing, a forward pass accelerates as hard as that allows
  /// (H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
  /// Reachability Analysis", 2018). Where only speed and acceleration of the tool bind, it is the
  /// trapezoid.
  static TimeLaw fastest(const PathBounds& bounds);
  /// The time law of a path without length.
  static TimeLaw standing();

  /// The same law, `factor` times slower throughout.
  TimeLaw slowed(double factor) const;

  double duration() const { return times_.back(); }
  /// Before 0: the start; after `duration()`: the end. Never allocates.
  State at(double seconds) const;
  /// Greatest ds/dt at s.
  double speed_at(double s) const;

 private:
  explicit TimeLaw(const std::vector<double>& squared_speeds);

  std::vector<double> times_;   // per knot, s
  std::vector<double> speeds_;  // ds/dt per knot
};

}  // namespace robcl::motion
