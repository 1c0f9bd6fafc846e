// How fast a path may be run through at each of its knots.
#pragma once

#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// Limits of ds/dt and d²s/dt² along a path. With x = (ds/dt)² and u = d²s/dt², joint i accelerates
/// by q'u + q''x: all limits are linear in (u, x), and standing (0, 0) is always allowed.
class PathBounds {
 public:
  struct Interval {
    double lower = 0, upper = 0;
    bool empty() const { return lower > upper; }
  };

  /// Starts with the limits of the joints at `pace`.
  PathBounds(const Path& path, const arm::ArmModel& model, const Pace& pace);

  /// The tool passes `length` m and turns by `turn` rad, evenly over the whole path.
  void add_tool(double length, double turn, const ToolLimits& limits, const Pace& pace);
  /// At this knot (ds/dt)² is at most `fastest`.
  void cap(std::size_t knot, double fastest);

  std::size_t intervals() const { return caps_.size() - 1; }
  double step() const { return 1.0 / static_cast<double>(intervals()); }

  /// Greatest (ds/dt)² at a knot as far as speed limits go.
  double speed_cap(std::size_t knot) const { return caps_[knot]; }
  /// Which u the acceleration limits allow at a knot that is passed with x.
  Interval at_knot(std::size_t knot, double x) const;
  /// Which u they allow from `knot` with x over the whole interval to the next knot, where
  /// x + 2·step·u is left.
  Interval over_interval(std::size_t knot, double x) const;
  /// Which u they allow anywhere, at s, with x: for braking on the path. Never allocates.
  Interval near(double s, double x) const;

 private:
  void restrict(Interval& interval, double per_u, double offset, double limit) const;
  void restrict_joints(Interval& interval, std::size_t knot, double x, double u_in_x) const;

  JointValues accelerations_;
  double tool_acceleration_;  // limit of d²s/dt² by the tool, with its m or rad divided out
  std::vector<double> caps_;  // (ds/dt)² per knot
  std::vector<JointValues> slopes_, curvatures_;
};

}  // namespace robcl::motion
