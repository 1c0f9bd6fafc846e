// The limits of the speed and acceleration along a path, in each interval of the path.
#pragma once

#include <limits>
#include <vector>

#include "robcl/arm/model.hpp"
#include "robcl/motion/path.hpp"

namespace robcl::motion {

inline constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double squared(double value) { return value * value; }

/// The limits in one interval of a path. The limits of the joints are given as fractions of the
/// limits in the model.
struct IntervalLimits {
  /// The limit |per_u·u| + |per_x·x| <= limit, with u = d²s/dt² and x = (ds/dt)². It limits the
  /// acceleration of the tool: `per_u` is the distance that the tool moves per unit of s, and
  /// `per_x` is the curvature of its path.
  struct Tool {
    double per_u = 0, per_x = 0;
    double limit = infinite;
  };

  double speed = 1, acceleration = 1;  ///< fractions
  double cap = infinite;               ///< greatest (ds/dt)²
  Tool way{}, turn{};                  ///< in m and in rad
};

/// The limits of ds/dt and d²s/dt² along a path with the parameter s. With x = (ds/dt)² and u =
/// d²s/dt², a joint q(s) has the acceleration q'u + q''x. Therefore all limits are linear in (u,
/// x). Rest, which is (0, 0), is always allowed. If (u, x) is allowed, so is (c·u, c·x) for each c
/// from 0 to 1.
///
/// In each interval between two knots, u is constant and x is linear in s.
class PathBounds {
 public:
  /// The allowed values of u at one x. Both ends of the interval are linear functions of x.
  struct Interval {
    double lower = 0, upper = 0;
    double lower_per_x = 0, upper_per_x = 0;  ///< slopes of `lower` and `upper`
    bool empty() const { return lower > upper; }
    void raise_lower(double value, double per_x) {
      if (value > lower) lower = value, lower_per_x = per_x;
    }
    void reduce_upper(double value, double per_x) {
      if (value < upper) upper = value, upper_per_x = per_x;
    }
  };

  /// `limits` has one element for each interval of `path`.
  PathBounds(const Path& path, const arm::ArmModel& model,
             const std::vector<IntervalLimits>& limits);

  /// In the interval after the knot `knot`, divides the limits of acceleration by the square of
  /// `factor`, and the limits of speed by `factor`.
  void tighten(std::size_t knot, double factor);

  std::size_t intervals() const { return stretches_.size(); }
  const std::vector<double>& places() const { return places_; }
  /// Returns the difference of s from the knot `knot` to the next one.
  double step(std::size_t knot) const { return places_[knot + 1] - places_[knot]; }

  /// Returns the greatest (ds/dt)² that the speed limits allow at the knot `knot`.
  double speed_cap(std::size_t knot) const { return caps_[knot]; }
  /// Returns the values of u = d²s/dt² that the limits allow from the knot `knot`, where (ds/dt)²
  /// is `x`, to the next knot. The limits are checked at both knots and in the middle between them.
  Interval over_interval(std::size_t knot, double x) const;
  /// Like over_interval, but for the remaining part of the interval: from the fraction `part` of
  /// the interval, where (ds/dt)² is `x`, to the next knot. With the returned values, the limits of
  /// acceleration hold everywhere in this part. Never allocates memory.
  Interval over_rest(std::size_t knot, double part, double x) const;
  /// Returns the greatest allowed d²s/dt² in the interval after the knot `knot`. If the tool moves
  /// on a straight line there, the result follows from the limit of the tool. Otherwise, it follows
  /// from the limits of the joints as if the path were not curved.
  double acceleration_limit(std::size_t knot) const;
  /// Returns the factor by which a motion must be slowed so that it keeps the limits everywhere
  /// from the knot `knot` to the next one. The factor is 1 if the motion already keeps the limits.
  /// The motion has (ds/dt)² = `x` at the knot `knot`, and d²s/dt² = `u` up to the next knot.
  double excess(std::size_t knot, double x, double u) const;

 private:
  /// One interval of the path. The curvature of the path is linear in s there.
  struct Stretch {
    JointValues slope, curvature;  ///< at the start of the interval
    JointValues change;            ///< of the curvature, up to the end of the interval
    IntervalLimits limits;
  };
  /// The acceleration of a joint at one place: per_u·u + per_x·x, with u = d²s/dt² and x =
  /// (ds/dt)².
  struct Acceleration {
    double per_u = 0, per_x = 0;
  };
  void cap(std::size_t knot, const JointValues& slope, const IntervalLimits& limits);
  Interval of_tool(std::size_t knot, double part, double x) const;
  double slope(std::size_t knot, Eigen::Index axis, double place) const;
  double acceleration_limit(std::size_t knot, Eigen::Index axis) const;
  Acceleration acceleration(std::size_t knot, Eigen::Index axis, double place, double part) const;
  Acceleration between(std::size_t knot, Eigen::Index axis, double start, double end,
                       double part) const;
  static void restrict(Interval& interval, const Acceleration& acceleration, double x,
                       double limit);

  JointValues accelerations_, speeds_;  // limits of the joints, at full pace
  std::vector<double> places_;          // s at each knot
  std::vector<double> caps_;            // greatest (ds/dt)² per knot
  std::vector<Stretch> stretches_;      // one per interval
};

}  // namespace robcl::motion
