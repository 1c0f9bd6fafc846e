#pragma once

#include <chrono>
#include <optional>

#include "gecos/base/clock.hpp"
#include "gecos/base/moment.hpp"

namespace gecos {

/// Remembers by how much two precise clocks differ, so that one of them need not be read. They
/// advance at the same speed; only a step of the wall clock or a suspension of the machine changes
/// the difference, and both change `Moment::now()`. Reads no clock. Not thread-safe.
class ClockDifference {
 public:
  /// A measurement may be wrong by the time that it took. Longer ones are not remembered, because
  /// the thread was interrupted between its readings.
  static constexpr Duration longest_measurement = std::chrono::microseconds(1);

  /// Returns the difference, or nullopt if it must be measured again. `moment`: now.
  std::optional<Duration> at(const Moment& moment) const {
    if (moment != measured_at_) return std::nullopt;
    return difference_;
  }

  /// Remembers the difference `measured` until the kernel tick of `moment` ends. `moment` must have
  /// been read before the measurement began; `took` is how long the measurement took.
  void remember(const Moment& moment, Duration measured, Duration took) {
    if (took > longest_measurement) return;
    measured_at_ = moment;
    // A difference that has not changed keeps its value, so that times do not run backwards by the
    // error of the measurement.
    if (std::chrono::abs(measured - difference_) > longest_measurement) difference_ = measured;
  }

 private:
  Moment measured_at_;
  Duration difference_{};
};

}  // namespace gecos
