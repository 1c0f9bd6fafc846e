#pragma once

#include <cstddef>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::qos {

/// Measures the latency of a connection before it is used: the median of at most `most` round
/// trips, which are made one after another within a bounded time. Reads no clock. Not thread-safe.
class LatencySample {
 public:
  static constexpr std::size_t most = 5;

  struct Latency {
    Duration round_trip{};
    bool answered = true;  ///< false: no answer came within `round_trip`
  };

  /// The measurement takes at most `longest`.
  LatencySample(TimePoint now, Duration longest) : begun_(now), longest_(longest) {}

  /// Returns whether another round trip should begin. No round trip begins in the second half of
  /// the measurement, so that the last round trip can end in time.
  bool wants_another(TimePoint now) const {
    return round_trips_.size() < most && now < begun_ + longest_ / 2;
  }
  /// Returns the time at which to stop waiting for an answer that has not arrived.
  TimePoint gives_up() const { return begun_ + longest_; }
  void answered(Duration round_trip) { round_trips_.push_back(round_trip); }
  /// Returns the median of the round trips; for an even number, the shorter of the two in the
  /// middle. If no answer came at all, returns the time since the measurement began.
  Latency latency(TimePoint now) const;

 private:
  const TimePoint begun_;
  const Duration longest_;
  std::vector<Duration> round_trips_;
};

}  // namespace gecos::qos
