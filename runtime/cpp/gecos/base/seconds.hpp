#pragma once

#include <algorithm>
#include <chrono>

#include "gecos/base/clock.hpp"

namespace gecos {

/// Returns `duration` in seconds. Interfaces state times in this form.
constexpr double to_seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Converts the time in s for which a caller waits. Returns zero for a negative number or NaN, and
/// about 30 years for longer times, including infinity.
constexpr Duration from_seconds(double seconds) {
  if (!(seconds > 0)) return Duration::zero();
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(seconds, 1e9)));
}

}  // namespace gecos
