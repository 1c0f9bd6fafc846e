// The path of the joints for a straight line of the tool.
#pragma once

#include <vector>

#include "gecos/base/result.hpp"
#include "robcl/arm/failure.hpp"
#include "robcl/arm/inverse.hpp"
#include "robcl/motion/line_deviation.hpp"

namespace robcl::motion {

/// The greatest distance of the tool from its line between two knots, in m.
inline constexpr double line_tolerance = mm(0.05);

struct LinePath {
  Path path;  ///< s is from 0 to the duration of the line
  /// The angle, in rad, above which two knots are moved closer together. Between the closest knots,
  /// a joint may turn further.
  double most_turned;
  /// For each interval, the greatest second derivatives by s of the distance and the angle of the
  /// tool from its line, in m and rad per square of s.
  std::vector<WayAndTurn> bends;
  /// For each interval, the greatest difference by which the speeds of the tool exceed those on the
  /// exact line, in m and rad per unit of s.
  std::vector<WayAndTurn> faster;
};

/// Makes the path on which the tool follows `line`, by solving the inverse kinematics at every
/// knot. Between the knots, the tool is at most `line_tolerance` from its line. The arm keeps the
/// configuration that it has at `from`. May fail with OutOfReach, JointLimit or Singular.
///
/// A joint may begin outside its limits: after a fault of the drives, it may stand one count of its
/// encoder beyond a limit. The line is then accepted if it leads back inside (first_outside()).
/// @pre the tool is at the start of `line` at the joint positions `from`, and `line.start` is 0.
tl::expected<LinePath, arm::Failure> path_of_line(const arm::ArmModel& model,
                                                  const arm::Kinematics& forward,
                                                  arm::InverseKinematics& inverse,
                                                  const JointValues& from, const LineOnPath& line);

}  // namespace robcl::motion
