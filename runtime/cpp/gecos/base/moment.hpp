#pragma once

#include <cstdint>

namespace gecos {

/// A reading of the kernel's two coarse clocks: it identifies the kernel tick (1 to 10 ms) in which
/// a thread runs, at half the cost of a precise clock. A default-constructed Moment equals no
/// reading.
struct Moment {
  std::int64_t monotonic_ns = 0;  ///< advances while the process is stopped
  std::int64_t unix_ns = 0;       ///< jumps when the machine was suspended

  static Moment now();

  /// Equal Moments are at most one kernel tick apart. The only exception is a wall clock that was
  /// set back by exactly the length of a suspension.
  friend bool operator==(const Moment&, const Moment&) = default;
};

}  // namespace gecos
