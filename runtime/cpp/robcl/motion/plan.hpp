#pragma once

#include "robcl/motion/bounds.hpp"
#include "robcl/motion/path.hpp"
#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// A planned move. It was checked from start to goal, so that it can be executed.
struct Plan {
  Path path;
  PathBounds braking;  ///< for a stop on the path: the limits of the arm at full pace
  TimeLaw law;

  const JointValues& start() const { return path.knot(0); }
  const JointValues& goal() const { return path.knot(path.intervals()); }
};

}  // namespace robcl::motion
