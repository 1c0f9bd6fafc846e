// Limits of the speed and acceleration along a path, at each of its knots.
#pragma once

#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// Limits of ds/dt and d²s/dt² along a path. With x = (ds/dt)² and u = d²s/dt², a joint q(s)
/// accelerates by q'u + q''x: all limits are linear in (u, x), and rest (0, 0) is always allowed.
class PathBounds {
 public:
  struct Interval {
    double lower = 0, upper = 0;
    bool empty() const { return lower > upper; }
  };

  /// Sets the limits of the joints, scaled by `pace`.
  PathBounds(const Path& path, const arm::ArmModel& model, const Pace& pace);

  /// Adds the limits of a tool that moves `length` m and turns `turn` rad, evenly over the path.
  void add_tool(double length, double turn, const ToolLimits& limits, const Pace& pace);
  /// Limits (ds/dt)² at `knot` to `fastest`.
  void cap(std::size_t knot, double fastest);

  std::size_t intervals() const { return caps_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }

  /// Greatest (ds/dt)² that the speed limits allow at `knot`.
  double speed_cap(std::size_t knot) const { return caps_[knot]; }
  /// The values of u = d²s/dt² that the acceleration limits allow at `knot`, where x = (ds/dt)².
  Interval at_knot(std::size_t knot, double x) const;
  /// The values of u = d²s/dt² that the acceleration limits allow from `knot` to the next knot.
  /// (ds/dt)² is x at `knot` and x + 2·step·u at the next knot.
  Interval over_interval(std::size_t knot, double x) const;
  /// The values of u = d²s/dt² that the acceleration limits allow at any `s`, where x = (ds/dt)²;
  /// for braking. Never allocates.
  Interval near(double s, double x) const;

 private:
  void restrict(Interval& interval, double per_u, double offset, double limit) const;
  void restrict_joints(Interval& interval, std::size_t knot, double x, double u_in_x) const;

  JointValues accelerations_;
  double tool_acceleration_;  // limit of d²s/dt² by the tool, 1/s²
  std::vector<double> caps_;  // greatest (ds/dt)² per knot
  std::vector<JointValues> slopes_, curvatures_;
};

}  // namespace robcl::motion
