#pragma once

#include <optional>
#include <vector>

#include "robcl/motion/bounds.hpp"
#include "robcl/motion/path.hpp"
#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// A planned move, which was checked from start to goal before its execution.
struct Plan {
  Path path;
  PathBounds braking;  ///< for a stop on the path: the limits of the arm at full pace
  TimeLaw law;
  Smoothing smoothing{};
  /// The knot of `path` at which a motion goes over from the previous plan into this plan; 0 if the
  /// motion begins with this plan. Up to this knot, both plans have the same path and time law.
  /// This common part begins at least one window of `smoothing` before the knot, or at the start of
  /// the motion.
  std::size_t entry = 0;

  double duration() const {
    return law.duration() + (law.duration() > 0 ? smoothing.window : 0);
  }  ///< s
  const JointValues& start() const { return path.knot(0); }
  const JointValues& goal() const { return path.knot(path.intervals()); }
};

/// The limits of each interval of a path during the move, and while the arm brakes.
struct CourseLimits {
  std::vector<IntervalLimits> moving, braking;
};

/// Plans the fastest motion on `path` whose set points keep all limits. The motion begins as
/// `start` says. If it does not begin at rest, `start` must last at least as long as the window of
/// `smoothing`. Returns nullopt if the arm cannot keep the limits after this start, or can keep
/// them only by a much slower motion. From rest, returns nullopt only if the limits make the arm
/// stop before the end, as limits of 0 do.
std::optional<Plan> fastest_plan(Path path, const arm::ArmModel& model, CourseLimits limits,
                                 const Smoothing& smoothing, const TimeLaw::Start& start = {});

}  // namespace robcl::motion
