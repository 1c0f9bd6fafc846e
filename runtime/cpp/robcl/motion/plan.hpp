#pragma once

#include "robcl/motion/bounds.hpp"
#include "robcl/motion/path.hpp"
#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// A move that was checked from end to end before anything turns.
struct Plan {
  Path path;
  PathBounds braking;  ///< what a stop on the way may do: all that the arm can
  TimeLaw law;

  const JointValues& start() const { return path.knot(0); }
  const JointValues& goal() const { return path.knot(path.intervals()); }
};

}  // namespace robcl::motion
