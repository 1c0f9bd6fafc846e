// Smoothing takes the mean of a motion over a window. This file computes by how much the mean
// exceeds the limits that the time law of the motion keeps.
#pragma once

#include <vector>

#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// Returns the factor by which `law` must be slowed in each interval of `path` so that the mean
/// over the window of `smoothing` keeps the limits of the joints. The factor is 1 where the mean
/// already keeps the limits. The mean can exceed limits that the time law keeps, because at one
/// place of the path the mean has speeds and accelerations that the time law has at other places.
/// `limits` has the limits of each interval. The mean is checked from the time at which `law` is at
/// the knot `from_knot`. @pre `law` begins at rest, or a window or more before this time.
std::vector<double> excess_of_mean(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits, const TimeLaw& law,
                                   std::size_t from_knot, const Smoothing& smoothing);

/// Returns `limits`, reduced for each interval of `path`, so that the mean of a motion over the
/// window of `smoothing` keeps the original limits. This holds for a motion whose time law keeps
/// the reduced limits and is nowhere faster than `fastest`.
std::vector<IntervalLimits> narrowed(const Path& path, const arm::ArmModel& model,
                                     std::vector<IntervalLimits> limits, const TimeLaw& fastest,
                                     const Smoothing& smoothing);

}  // namespace robcl::motion
