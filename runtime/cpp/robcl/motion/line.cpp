#include "robcl/motion/line.hpp"

#include <iomanip>
#include <sstream>

namespace robcl::motion {

Line::Line(const Frame& start, const Frame& goal)
    : start_(start),
      goal_(goal),
      way_(goal.position() - start.position()),
      turn_(rotation_vector(start.orientation().conjugate() * goal.orientation())) {}

std::string Line::place(double part) const {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (length() > 0) {
    text << in_mm(length() * part) << " mm along the line";
  } else {
    text << in_deg(turn() * part) << " deg into the turn";
  }
  return text.str();
}

}  // namespace robcl::motion
