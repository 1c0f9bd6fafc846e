#pragma once

#include <cstdint>

namespace gecos {

/// The values of the kernel's two coarse clocks at one moment. They identify the kernel tick (1 to
/// 10 ms) in which a thread runs, at half the cost of a precise clock. A default-constructed Moment
/// differs from every result of `now()`.
struct Moment {
  std::int64_t monotonic_ns = 0;  ///< advances while the process is stopped
  std::int64_t unix_ns = 0;       ///< jumps when the machine was suspended

  static Moment now();

  /// Compares two moments. Equal Moments are at most one kernel tick apart, except when the wall
  /// clock was set back by exactly the length of a suspension of the machine.
  friend bool operator==(const Moment&, const Moment&) = default;
};

}  // namespace gecos
