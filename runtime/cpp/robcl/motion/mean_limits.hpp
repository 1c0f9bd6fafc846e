// How far the mean of a motion over the window of Smoothing may exceed the limits that its time law
// keeps.
#pragma once

#include <vector>

#include "robcl/motion/time_law.hpp"

namespace robcl::motion {

/// The mean of a motion is at one place of the path, with the speeds and accelerations that its
/// time law has at other places, so that it may exceed limits that the time law keeps. Returns the
/// factor by which `law` must be slowed in each interval of `path` so that its mean keeps the
/// limits of the joints; 1 where the mean keeps them. `limits`: those of each interval. The mean
/// is judged from the time at which `law` is at the knot `from_knot`. @pre `law` begins at rest, or
/// a window or more before this time.
std::vector<double> excess_of_mean(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits, const TimeLaw& law,
                                   std::size_t from_knot, const Smoothing& smoothing);

/// Returns the limits of each interval of `path`, which are `limits`, reduced by what the mean may
/// exceed them by, of any motion that is nowhere faster than `fastest`.
std::vector<IntervalLimits> narrowed(const Path& path, const arm::ArmModel& model,
                                     std::vector<IntervalLimits> limits, const TimeLaw& fastest,
                                     const Smoothing& smoothing);

}  // namespace robcl::motion
