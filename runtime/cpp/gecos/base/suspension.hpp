#pragma once

#include "gecos/base/clock.hpp"

namespace gecos {

/// Returns the total time for which this machine was suspended since its start, as
/// note_suspension() last measured it. The kernel's coarse monotonic clock stands still during a
/// suspension; a program that adds this total time to that clock gets an approximation of
/// CLOCK_BOOTTIME. Costs one load. Thread-safe.
Duration noted_suspension();
/// Measures the total time of suspension again, so that noted_suspension() returns the present
/// value. The maintenance thread calls this function at each tick.
void note_suspension(const Clock& clock);

}  // namespace gecos
