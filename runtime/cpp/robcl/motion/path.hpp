// The geometric path of the joints, without times.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "robcl/arm/failure.hpp"
#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"

namespace robcl::motion {

using arm::JointValues;

/// The joint positions as a function of the path parameter s. The path has knots; between them it
/// is a cubic Hermite spline, so that position and slope are continuous. Reading a path never
/// allocates memory.
class Path {
 public:
  /// The knots from which a path is made.
  struct Knots {
    std::vector<double> places;       ///< s at each knot, rising
    std::vector<JointValues> joints;  ///< rad
    /// The derivatives of the joint positions by s at the first knots, if the path continues
    /// another path and must have the same derivatives there. The path computes the derivatives at
    /// all knots that have no element here.
    std::vector<JointValues> first_slopes{};

    void add(double place, JointValues at) {
      places.push_back(place);
      joints.push_back(std::move(at));
    }
  };

  /// @pre there are at least two knots, and all have the same number of joints.
  explicit Path(Knots knots);

  std::size_t intervals() const { return knots_.places.size() - 1; }
  double begin() const { return knots_.places.front(); }  ///< s
  double end() const { return knots_.places.back(); }     ///< s
  double place(std::size_t knot) const { return knots_.places[knot]; }
  const std::vector<double>& places() const { return knots_.places; }
  /// Returns the difference of s from the knot `i` to the next one.
  double step(std::size_t i) const { return knots_.places[i + 1] - knots_.places[i]; }
  /// Returns the index of the interval that contains `s`, or of the nearest one.
  std::size_t interval_at(double s) const;

  const JointValues& knot(std::size_t i) const { return knots_.joints[i]; }
  /// Returns the first derivative of the joint positions by s at the knot `i`.
  const JointValues& slope(std::size_t i) const { return slopes_[i]; }

  /// The first and the second derivative of the joint positions by s.
  struct Derivatives {
    JointValues slope, curvature;
  };
  /// Returns the derivatives in the interval that begins at the knot `interval`, at the fraction
  /// `part` of this interval, from 0 to 1. The curvature is linear in an interval, and may jump at
  /// its ends.
  Derivatives derivatives(std::size_t interval, double part) const;

  /// The range of the positions of each joint.
  struct Range {
    JointValues lowest, highest;
  };
  /// Returns the least and the greatest positions of the joints from the knot `i` to the next one.
  /// Between two knots, a joint may be outside the range of its positions at these knots.
  Range range(std::size_t i) const;

  /// Returns the joint positions at `s`. For an `s` outside the path, returns the joint positions
  /// at the nearer end of the path.
  JointValues position(double s) const;

 private:
  JointValues slope_from_knots(std::size_t i) const;

  Knots knots_;
  std::vector<JointValues> slopes_;
};

/// A joint that leaves its limits on a path, and the place on the path.
struct OutsideOnPath {
  arm::JointLimit limit;
  double s = 0;
};
/// Finds the first interval of `path` in which a joint leaves its limits. Returns such a joint, and
/// s at the knot at which this interval begins; nullopt if all joints stay inside their limits.
///
/// A joint that is outside its limits at the start of `path` may return: until the first knot at
/// which it is inside, it counts as outside only where it is further outside than at the start. At
/// the end of `path` it must be inside.
std::optional<OutsideOnPath> first_outside(const arm::ArmModel& model, const Path& path);

}  // namespace robcl::motion
