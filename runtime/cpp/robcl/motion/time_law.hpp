// Time laws. A time law is the path parameter s as a function of time.
#pragma once

#include <optional>
#include <vector>

#include "robcl/motion/bounds.hpp"

namespace robcl::motion {

/// A time law that ends at rest. Between two knots, d²s/dt² is constant.
class TimeLaw {
 public:
  struct State {
    double s = 0;
    double speed = 0;         ///< ds/dt, 1/s
    double acceleration = 0;  ///< d²s/dt², 1/s²
  };

  /// Returns the fastest time law that keeps all limits. A backward pass finds the greatest speed
  /// at each knot from which the arm can still stop at the end. A forward pass then accelerates as
  /// hard as these speeds allow. The method is that of H. Pham and Q.-C. Pham, "A New Approach to
  /// Time-Optimal Path Parameterization Based on Reachability Analysis", 2018. If only the limits
  /// of the tool apply, the speed profile is a trapezoid.
  static TimeLaw fastest(const PathBounds& bounds) { return *fastest_from(bounds, 0); }
  /// Returns the fastest time law that starts with the speed ds/dt = `speed`; nullopt if no time
  /// law with this speed keeps all limits.
  static std::optional<TimeLaw> fastest_from(const PathBounds& bounds, double speed);
  /// Returns the time law of a path without length.
  static TimeLaw standing();

  /// Returns this time law with all times multiplied by `factor`.
  TimeLaw slowed(double factor) const;

  double duration() const { return times_.back(); }
  /// Returns the state at the time `seconds`: the start for times before 0, and the end for times
  /// after `duration()`. Never allocates memory.
  State at(double seconds) const;
  /// Returns the speed ds/dt of this time law at the knot `knot`, in 1/s.
  double speed(std::size_t knot) const { return speeds_[knot]; }
  /// Returns the time in s at which this time law is at the knot `knot`.
  double time(std::size_t knot) const { return times_[knot]; }
  /// Returns the time in s at which this time law is at `s`. Never allocates memory.
  double time_at(double s) const;

 private:
  TimeLaw(std::vector<double> places, const std::vector<double>& squared_speeds);

  std::vector<double> places_;  // s at each knot
  std::vector<double> times_;   // time at each knot, s
  std::vector<double> speeds_;  // ds/dt at each knot, 1/s
};

}  // namespace robcl::motion
