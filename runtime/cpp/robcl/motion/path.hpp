// The geometric path of the joints. It has no times.
#pragma once

#include <cstddef>
#include <vector>

#include "robcl/arm/joint_values.hpp"

namespace robcl::motion {

using arm::JointValues;

/// The joint positions as a function of the path parameter s in [0, 1]. The path has knots at equal
/// steps of s. Between the knots it is a cubic Hermite spline, so that position and slope are
/// continuous. Reading a path never allocates memory.
class Path {
 public:
  /// Makes a path through the joint positions `knots`. @pre there are at least two knots, and all
  /// have the same number of joints.
  explicit Path(std::vector<JointValues> knots);

  std::size_t intervals() const { return knots_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }
  const JointValues& knot(std::size_t i) const { return knots_[i]; }
  /// Returns the first derivative of the joint positions by s at the knot `i`.
  const JointValues& slope(std::size_t i) const { return slopes_[i]; }

  /// The first and the second derivative of the joint positions by s.
  struct Derivatives {
    JointValues slope, curvature;
  };
  /// Returns the derivatives in the interval that begins at the knot `interval`, at the fraction
  /// `part` of it, from 0 to 1. The curvature is linear in an interval, and may jump at its ends.
  Derivatives derivatives(std::size_t interval, double part) const;

  /// Returns the joint positions at `s`. For an `s` outside [0, 1], returns the nearer end of the
  /// path.
  JointValues position(double s) const;

 private:
  std::vector<JointValues> knots_;
  std::vector<JointValues> slopes_;
};

}  // namespace robcl::motion
