#include "robcl/motion/line.hpp"

namespace robcl::motion {

Line::Line(const Frame& start, const Frame& goal)
    : start_(start),
      goal_(goal),
      way_(goal.position() - start.position()),
      turn_(rotation_vector(start.orientation().conjugate() * goal.orientation())) {}

}  // namespace robcl::motion
