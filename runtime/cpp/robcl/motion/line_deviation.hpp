// By how much the tool leaves its line between the knots of a path.
#pragma once

#include <algorithm>

#include "robcl/arm/kinematics.hpp"
#include "robcl/motion/line.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// A line of the tool as a function of the path parameter s.
struct LineOnPath {
  Line line;
  Frame flange_from_tool;
  double start = 0;     ///< s at the start of the line
  double duration = 0;  ///< difference of s from the start of the line to its end

  /// Returns the place of the tool at `s`. For an `s` outside the line, returns the nearer end of
  /// the line.
  Frame at(double s) const { return line.at(std::clamp((s - start) / duration, 0.0, 1.0)); }
};

/// How far the tool is from its line in one interval of a path, in m and rad. The tool is on the
/// line at both knots. Between the knots the joint positions are cubic polynomials of s, so the
/// distance is the sum of an even part, which is greatest in the middle, and of an odd part, which
/// is greatest near 1/4 and 3/4 of the interval.
struct LineDeviation {
  WayAndTurn even, odd;
  /// The greatest first derivatives by s of the deviation, along the line and about the axis about
  /// which the tool turns on the line, in m and rad per unit of s. The speeds of the tool may
  /// exceed those on the exact line by these values.
  WayAndTurn faster;

  /// Returns a bound of the distance of the tool from its line, in m. The angle has no bound:
  /// between two knots, the tool may turn further than the line demands.
  double furthest() const { return even.way + odd.way; }
  /// Returns the greatest second derivatives by s of the distance and the angle, in m and rad per
  /// square of s. `step` is the length of the interval in s. The even and the odd part of the
  /// deviation bend most at the knots.
  WayAndTurn bend(double step) const;
};

/// Returns the deviation from `line` in the interval `interval` of `path`.
LineDeviation deviation_in(const Path& path, std::size_t interval, const LineOnPath& line,
                           const arm::Kinematics& forward);

}  // namespace robcl::motion
