// Where the joints pass, without saying when.
#pragma once

#include <cstddef>
#include <vector>

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// Joint positions over s in [0, 1]: knots at equal steps, a cubic Hermite between them, so
/// position and slope are continuous. Reading never allocates.
class Path {
 public:
  /// @pre at least two knots, all of one size.
  explicit Path(std::vector<JointValues> knots);

  std::size_t intervals() const { return knots_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }
  const JointValues& knot(std::size_t i) const { return knots_[i]; }
  /// dq/ds and d²q/ds² at a knot.
  const JointValues& slope(std::size_t i) const { return slopes_[i]; }
  JointValues curvature(std::size_t i) const;

  /// `s` outside [0, 1] gives the nearer end.
  JointValues position(double s) const;

 private:
  std::vector<JointValues> knots_;
  std::vector<JointValues> slopes_;
};

}  // namespace robcl::motion
