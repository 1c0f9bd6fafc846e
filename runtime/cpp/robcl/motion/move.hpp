// A move of the arm, before the times of its motion are planned.
#pragma once

#include <optional>
#include <vector>

#include "robcl/frames/frame.hpp"
#include "robcl/motion/bounds.hpp"
#include "robcl/motion/line.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// The path of one move and its limits. The path parameter s is the nominal time in seconds: where
/// ds/dt is 1, the slowest joint or the tool moves at the full speed of the move.
struct Move {
  Path path;  ///< s is from 0 to the nominal duration
  Pace pace;
  std::optional<Line> line;  ///< path of the tool, seen from the base; nullopt for a joint move
  Frame flange_from_tool;
  bool stands = false;         ///< the goal is where the arm is
  std::vector<double> caps{};  ///< greatest (ds/dt)² in each interval; may be empty
  /// For each interval, the greatest second derivatives by s of the distance and the angle of the
  /// tool from its line, in m and rad per square of s; may be empty.
  std::vector<WayAndTurn> bends{};
  /// For each interval, the greatest difference by which the speeds of the tool exceed those on the
  /// exact line, in m and rad per unit of s; may be empty.
  std::vector<WayAndTurn> faster{};
  /// The angle, in rad, above which two knots are moved closer together. Between the closest knots,
  /// a joint may turn further. Smaller than `joint_step` if the tool would otherwise leave its
  /// line.
  double most_turned = joint_step;

  double duration() const { return path.end(); }
  const JointValues& goal() const { return path.knot(path.intervals()); }
};

/// Lowers the cap of (ds/dt)² in an interval of a straight move, so that the tool keeps the limits
/// `speed`, in m/s and rad/s. Where the tool deviates from its line, it moves and turns faster than
/// on the line. `faster` is the greatest difference of these speeds, in m and rad per unit of the
/// path parameter s.
void lower_cap(IntervalLimits& limits, const WayAndTurn& speed, const WayAndTurn& faster);

/// Returns the speed of the tool on the line of `move`, in m and rad per unit of s; zeros for a
/// joint move.
WayAndTurn tool_speed(const Move& move);

/// Returns the limits of the tool at `pace`.
ToolLimits scaled(const ToolLimits& limits, const Pace& pace);

/// Returns the limits of each interval of `move`. `limits` are the limits of the tool.
std::vector<IntervalLimits> limits_of(const Move& move, const ToolLimits& limits);
/// Returns the limits of each interval of `move` that apply while the arm brakes on the path. They
/// are the limits of a move at full pace, whatever the pace of `move`.
std::vector<IntervalLimits> braking_limits_of(const Move& move, const ToolLimits& limits);

}  // namespace robcl::motion
