// The limits of the speed and acceleration along a path, in each interval of the path.
#pragma once

#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// The limits of ds/dt and d²s/dt² along a path with the parameter s. With x = (ds/dt)² and u =
/// d²s/dt², a joint q(s) has the acceleration q'u + q''x. Therefore all limits are linear in (u,
/// x). Rest, which is (0, 0), is always allowed. If (u, x) is allowed, so is (c·u, c·x) for each c
/// from 0 to 1.
///
/// In each interval between two knots, u is constant and x is linear in s. The limits are checked
/// at the start, in the middle and at the end of the interval.
class PathBounds {
 public:
  struct Interval {
    double lower = 0, upper = 0;
    bool empty() const { return lower > upper; }
  };

  /// Makes the limits of the joints, scaled by `pace`.
  PathBounds(const Path& path, const arm::ArmModel& model, const Pace& pace);

  /// Adds the limits of a tool that, evenly over the whole path, moves by `length`, in m, and turns
  /// by `turn`, in rad.
  void add_tool(double length, double turn, const ToolLimits& limits, const Pace& pace);
  /// Limits (ds/dt)² at the knot `knot` to `fastest`.
  void cap(std::size_t knot, double fastest);

  std::size_t intervals() const { return caps_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }

  /// Returns the greatest (ds/dt)² that the speed limits allow at the knot `knot`.
  double speed_cap(std::size_t knot) const { return caps_[knot]; }
  /// Returns the values of u = d²s/dt² that the limits allow from the fraction `part` of the
  /// interval that begins at the knot `knot`, where (ds/dt)² is `x`, to the end of the interval.
  /// Never allocates memory.
  Interval over_interval(std::size_t knot, double x, double part = 0) const;

 private:
  /// The curvature of the path is linear in an interval.
  struct Bend {
    JointValues slope, curvature;  ///< at the start of the interval
    JointValues change;            ///< of the curvature, up to the end of the interval
  };
  static void restrict(Interval& interval, double per_u, double offset, double limit);

  JointValues accelerations_;
  JointValues speeds_;
  double tool_acceleration_;  // limit of d²s/dt² by the tool, 1/s²
  std::vector<double> caps_;  // greatest (ds/dt)² per knot
  std::vector<Bend> bends_;   // one per interval
};

}  // namespace robcl::motion
