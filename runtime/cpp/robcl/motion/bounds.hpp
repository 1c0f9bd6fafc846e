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
/// In each interval between two knots, u is constant and x is linear in s.
class PathBounds {
 public:
  /// Allowed values of u at one x. The limits that set its ends are straight lines over x.
  struct Interval {
    double lower = 0, upper = 0;
    double lower_per_x = 0, upper_per_x = 0;  ///< slopes of these lines
    bool empty() const { return lower > upper; }
    void raise_lower(double value, double per_x) {
      if (value > lower) lower = value, lower_per_x = per_x;
    }
    void reduce_upper(double value, double per_x) {
      if (value < upper) upper = value, upper_per_x = per_x;
    }
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
  /// Returns the values of u = d²s/dt² that the limits allow from the knot `knot` to the next one.
  /// (ds/dt)² is `x` at this knot. The limits are checked at both knots and in the middle.
  Interval over_interval(std::size_t knot, double x) const;
  /// Returns the same from the fraction `part` of that interval, where (ds/dt)² is `x`, to the next
  /// knot. The limits of acceleration hold everywhere in this part. Never allocates memory.
  Interval over_rest(std::size_t knot, double part, double x) const {
    return everywhere(knot, part, part, x);
  }
  /// Returns the greatest deceleration -d²s/dt² with which the limits of acceleration hold
  /// everywhere from the fraction `part` of that interval to the next knot, where the motion comes
  /// to rest. Never allocates memory.
  double hardest_to_rest(std::size_t knot, double part) const {
    return -everywhere(knot, part, 1, 0).lower;
  }
  /// Returns the factor by which a motion must be slowed so that it keeps the limits everywhere
  /// from the knot `knot` to the next one; 1 if it keeps them. (ds/dt)² is `x` at this knot.
  double excess(std::size_t knot, double x, double u) const;

 private:
  /// The curvature of the path is linear in an interval.
  struct Bend {
    JointValues slope, curvature;  ///< at the start of the interval
    JointValues change;            ///< of the curvature, up to the end of the interval
  };
  /// The acceleration of a joint at one place: per_u·u + per_x·x.
  struct Acceleration {
    double per_u = 0, per_x = 0;
  };
  Interval everywhere(std::size_t knot, double from, double part, double x) const;
  double slope(std::size_t knot, Eigen::Index axis, double place) const;
  Acceleration acceleration(std::size_t knot, Eigen::Index axis, double place, double part) const;
  Acceleration between(std::size_t knot, Eigen::Index axis, double start, double end,
                       double part) const;
  static void restrict(Interval& interval, const Acceleration& acceleration, double x,
                       double limit);

  JointValues accelerations_;
  JointValues speeds_;
  double tool_acceleration_;  // limit of d²s/dt² by the tool, 1/s²
  std::vector<double> caps_;  // greatest (ds/dt)² per knot
  std::vector<Bend> bends_;   // one per interval
};

}  // namespace robcl::motion
