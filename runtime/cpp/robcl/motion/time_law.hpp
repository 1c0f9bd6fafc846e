// Time laws. A time law is the path parameter s as a function of time.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "robcl/motion/bounds.hpp"
#include "robcl/motion/smoothing.hpp"

namespace robcl::motion {

/// A time law that ends at rest. Between two knots, d²s/dt² is constant.
class TimeLaw {
 public:
  struct State {
    double s = 0;
    double speed = 0;         ///< ds/dt, 1/s
    double acceleration = 0;  ///< d²s/dt², 1/s²
  };

  /// The least and the greatest of some values of d²s/dt².
  struct Range {
    double least = 0, greatest = 0;
    void add(double value) {
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
  };
  /// The part of a motion that is already decided: (ds/dt)² at the first knots, at least one. From
  /// the last of these knots on, the motion is planned.
  struct Start {
    std::vector<double> squares{0};

    std::size_t knot() const { return squares.size() - 1; }  ///< the last of these knots
    bool at_rest() const { return squares.size() == 1 && squares.front() == 0; }
  };
  /// Returns the fastest time law that begins with `start` and keeps all limits. A backward pass
  /// finds the greatest speed at each knot from which the arm can still stop at the end. A forward
  /// pass then accelerates as hard as these speeds allow. The method is that of H. Pham and Q.-C.
  /// Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
  /// 2018. If only the limits of the tool apply, the speed profile is a trapezoid.
  ///
  /// A limit of jerk limits the change of d²s/dt² within the window of `smoothing`: the motion
  /// cannot accelerate at one moment and brake at the next, but moves at constant speed in between.
  ///
  /// Returns nullopt if no time law keeps all limits after this start, or if the limits make the
  /// arm stop before the end.
  static std::optional<TimeLaw> fastest(const PathBounds& bounds, const Start& start,
                                        const Smoothing& smoothing);
  /// Returns the time law of a path without length.
  static TimeLaw standing();

  /// Returns this time law with all times multiplied by `factor`.
  TimeLaw slowed(double factor) const;

  double duration() const { return times_.back(); }
  /// Returns the factor by which this time law must be slowed in each interval so that d²s/dt² does
  /// not change by more than `smoothing` allows within a window. The factor is 1 where the time law
  /// already keeps this limit.
  std::vector<double> change_excess(const PathBounds& bounds, const Smoothing& smoothing) const;
  /// Returns the state at the time `seconds`. For a time after `duration()`, this is the state at
  /// the end. For a time before 0, it is the state of a motion that comes to the start with
  /// constant speed. Never allocates memory.
  State at(double seconds) const;
  /// Returns the speed ds/dt of this time law at the knot `knot`, in 1/s.
  double speed(std::size_t knot) const { return speeds_[knot]; }
  /// Returns (ds/dt)² at each knot.
  const std::vector<double>& squares() const { return squares_; }
  const std::vector<double>& places() const { return places_; }
  /// Returns d²s/dt² from the knot `knot` to the next one.
  double acceleration(std::size_t knot) const {
    return (squares_[knot + 1] - squares_[knot]) / (2 * (places_[knot + 1] - places_[knot]));
  }
  /// Returns the least and the greatest d²s/dt² from the time `from` to the time `to`, in s. Never
  /// allocates memory.
  Range accelerations(double from, double to) const;
  /// Returns the time in s at which this time law is at the knot `knot`.
  double time(std::size_t knot) const { return times_[knot]; }
  /// Returns the last knot that this time law has passed at the time `seconds`, which is from 0 to
  /// `duration()`. Never allocates memory.
  std::size_t knot_at(double seconds) const;
  /// Returns the time in s at which this time law is at `s`. Never allocates memory.
  double time_at(double s) const;

 private:
  TimeLaw(std::vector<double> places, std::vector<double> squared_speeds);

  std::vector<double> places_;   // s at each knot
  std::vector<double> times_;    // time at each knot, s
  std::vector<double> squares_;  // (ds/dt)² at each knot
  std::vector<double> speeds_;   // ds/dt at each knot, 1/s
};

}  // namespace robcl::motion
