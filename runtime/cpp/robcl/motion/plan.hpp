#pragma once

#include <optional>
#include <vector>

#include "robcl/motion/bounds.hpp"
#include "robcl/motion/path.hpp"
#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// A planned move. It was checked from start to goal, so that it can be executed.
struct Plan {
  Path path;
  PathBounds braking;  ///< for a stop on the path: the limits of the arm at full pace
  TimeLaw law;
  Smoothing smoothing{};
  /// A motion that goes over into this plan does so at this knot. Before it, the plan is the one
  /// that the motion had, for the length of the window of `smoothing`.
  std::size_t entry = 0;

  double duration() const {
    return law.duration() + (law.duration() > 0 ? smoothing.window : 0);
  }  ///< s
  const JointValues& start() const { return path.knot(0); }
  const JointValues& goal() const { return path.knot(path.intervals()); }
};

/// The limits of each interval of a path: those of the move, and those that apply while the arm
/// brakes.
struct CourseLimits {
  std::vector<IntervalLimits> moving, braking;
};

/// Plans the fastest motion on `path` whose set points keep all limits. The motion begins as
/// `start` says. Returns nullopt if the arm cannot keep the limits from this start; from rest it
/// always can.
std::optional<Plan> fastest_plan(Path path, const arm::ArmModel& model, CourseLimits limits,
                                 const Smoothing& smoothing, const TimeLaw::Start& start = {});

}  // namespace robcl::motion
