#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"
#include "gecos/base/moment.hpp"

namespace gecos {

/// Remembers by how much the wall clock is ahead of CLOCK_BOOTTIME, so that only one of these two
/// precise clocks need be read. The difference changes only when the wall clock is set, and then
/// the difference of the two coarse clocks of a Moment changes, too. Reads no clock. Not
/// thread-safe.
class ClockDifference {
 public:
  /// A measurement may be wrong by the time that it took. Longer ones are not remembered, because
  /// the thread was interrupted between its readings.
  static constexpr Duration longest_measurement = std::chrono::microseconds(5);

  /// Returns the difference, or nullopt if it must be measured. `moment`: now.
  std::optional<Duration> at(const Moment& moment) const {
    if (!known_ || coarse_difference(moment) != coarse_) return std::nullopt;
    return difference_;
  }

  /// Remembers the difference `measured`, and returns true, unless the measurement took too long.
  /// `moment` must have been read before the measurement began; `took` is how long it took.
  bool remember(const Moment& moment, Duration measured, Duration took) {
    if (took > longest_measurement) return false;
    coarse_ = coarse_difference(moment);
    // A suspension of the machine and a tick of the kernel between the two readings of a Moment
    // cause a new measurement, too. The difference then keeps its value, so that times do not run
    // backwards by the error of the measurement.
    if (!known_ || std::chrono::abs(measured - difference_) > longest_measurement) {
      difference_ = measured;
    }
    known_ = true;
    return true;
  }

 private:
  static constexpr std::int64_t coarse_difference(const Moment& moment) {
    return moment.unix_ns - moment.monotonic_ns;
  }

  bool known_ = false;
  std::int64_t coarse_ = 0;  ///< that of the coarse clocks, in ns, at the last measurement
  Duration difference_{};
};

}  // namespace gecos
