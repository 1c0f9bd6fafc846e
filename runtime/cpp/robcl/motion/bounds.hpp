// The limits of the speed and acceleration along a path, at each knot of the path.
#pragma once

#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/pace.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

/// The limits of ds/dt and d²s/dt² along a path with the parameter s. With x = (ds/dt)² and u =
/// d²s/dt², a joint q(s) has the acceleration q'u + q''x. Therefore all limits are linear in (u,
/// x). Rest, which is (0, 0), is always allowed.
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
  /// Returns the values of u = d²s/dt² that the acceleration limits allow at the knot `knot`, where
  /// (ds/dt)² is `x`.
  Interval at_knot(std::size_t knot, double x) const;
  /// Returns the values of u = d²s/dt² that the acceleration limits allow from the knot `knot` to
  /// the next knot. (ds/dt)² is `x` at this knot, and `x` + 2·step·u at the next knot.
  Interval over_interval(std::size_t knot, double x) const;
  /// Returns the values of u = d²s/dt² that the acceleration limits allow at `s`, which may be
  /// between two knots, where (ds/dt)² is `x`. Playback uses them for braking. Never allocates
  /// memory.
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
