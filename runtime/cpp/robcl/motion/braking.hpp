// The speed that a motion may have if it must stop within a distance and its speed changes once per
// control cycle.
#pragma once

#include <algorithm>
#include <cmath>

namespace robcl::motion {

/// Returns the greatest speed for the next cycle from which a motion can stop after exactly
/// `distance`. The speed falls by at most acceleration·cycle from one cycle to the next. The last
/// cycle may have any speed up to acceleration·cycle. With a = acceleration·cycle and the speeds v,
/// v - a, … in N cycles, the distance is cycle·(N·v - a·N·(N - 1)/2). @pre all arguments are
/// positive; `distance` may also be 0.
inline double stopping_speed(double distance, double acceleration, double cycle) {
  const double change = acceleration * cycle;
  const double cycles = distance / (change * cycle);
  const double count = std::max(1.0, std::ceil((std::sqrt(1 + 8 * cycles) - 1) / 2));
  return distance / (count * cycle) + change * (count - 1) / 2;
}

/// Returns the distance that a motion covers after a cycle with the speed `speed` if it brakes in
/// all following cycles.
inline double stopping_distance(double speed, double acceleration, double cycle) {
  const double change = acceleration * cycle;
  const double count = std::floor(speed / change);
  return cycle * count * (speed - change * (count + 1) / 2);
}

}  // namespace robcl::motion
