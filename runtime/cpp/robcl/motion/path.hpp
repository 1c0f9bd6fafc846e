// The geometric path of the joints, without times.
#pragma once

#include <cstddef>
#include <vector>

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Joint positions over s in [0, 1]: knots at equal steps, with cubic Hermite splines between them,
/// so that position and slope are continuous. Reading never allocates.
class Path {
 public:
  /// @pre at least two knots, all with the same number of joints.
  explicit Path(std::vector<JointValues> knots);

  std::size_t intervals() const { return knots_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }
  const JointValues& knot(std::size_t i) const { return knots_[i]; }
  /// First (slope) and second (curvature) derivative of the joint positions by s at a knot.
  const JointValues& slope(std::size_t i) const { return slopes_[i]; }
  JointValues curvature(std::size_t i) const;

  /// The joint positions at `s`; an `s` outside [0, 1] gives the nearer end.
  JointValues position(double s) const;

 private:
  std::vector<JointValues> knots_;
  std::vector<JointValues> slopes_;
};

}  // namespace robcl::motion
