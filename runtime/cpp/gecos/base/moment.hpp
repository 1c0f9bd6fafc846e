#pragma once

#include <cstdint>

namespace gecos {

/// Readings of the kernel's two coarse clocks: about the tick of the kernel (1 to 10 ms) in which a
/// thread runs, for half of what a precise clock costs. Never at first.
struct Moment {
  std::int64_t monotonic_ns = 0;  ///< goes on while a process is stopped
  std::int64_t unix_ns = 0;       ///< and has leapt when a machine was suspended

  static Moment now();

  /// Certainly no more than a tick has passed between the two. Only a wall clock that was set back
  /// by the length of a suspension, to the nanosecond, could deceive it.
  friend bool operator==(const Moment&, const Moment&) = default;
};

}  // namespace gecos
