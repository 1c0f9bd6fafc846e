#pragma once

#include "robcl/arm/failure.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::motion {

/// The tool moves and turns by at most this distance in m and angle in rad between two knots of its
/// path. The knots are so dense that the tool stays on the line although the joints move on curves
/// between the knots.
inline constexpr double line_step = mm(1), turn_step = deg(0.2);
/// A joint turns by at most this angle, in rad, between two knots of a path. The knots are placed
/// accordingly.
inline constexpr double joint_step = 0.03;

/// A distance and an angle of the tool, in m and rad, or derivatives of them.
struct WayAndTurn {
  double way = 0, turn = 0;
};

/// The straight line between two frames. While the position moves along the line, the orientation
/// turns evenly about one axis, by at most 180 degrees.
class Line {
 public:
  Line(const Frame& start, const Frame& goal);

  double length() const { return way_.norm(); }  ///< m
  double turn() const { return turn_.norm(); }   ///< rad
  /// Returns the displacement from the start to the goal, in m.
  const Eigen::Vector3d& way() const { return way_; }
  /// Returns the rotation from the start to the goal as its axis, seen from the start, times its
  /// angle in rad. Half a turn could be made in either direction; this is the one that `at` makes.
  const Eigen::Vector3d& rotation() const { return turn_; }
  /// Returns the frame after the fraction `part` of the line. `part` is from 0 to 1.
  Frame at(double part) const { return interpolate(start_, goal_, part); }
  /// Returns the distance and the angle from the start of the line to the fraction `part` of the
  /// line.
  arm::PlaceOnLine place(double part) const { return {length() * part, turn() * part}; }

 private:
  Frame start_, goal_;
  Eigen::Vector3d way_;
  Eigen::Vector3d turn_;  // axis times angle (rad), seen from the start
};

}  // namespace robcl::motion
