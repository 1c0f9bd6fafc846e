#pragma once

#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"

namespace gecos::qos {

/// Judges by probes whether the round trip of a connection stays within its bound. The connection
/// is degraded once no probe has come back within the bound for `judged_after`, and has recovered
/// once all probes have done so for as long. Between two changes there is at least that time, so a
/// single slow answer is no change. Reads no clock. Not thread-safe.
class LatencyWatch {
 public:
  static constexpr Duration judged_after = std::chrono::seconds(1);
  /// Time between two probes, also while the connection is as it should be.
  static constexpr Duration usual_pause = std::chrono::seconds(1);
  /// Time between two probes while the connection may change.
  static constexpr Duration short_pause = std::chrono::milliseconds(100);

  enum class Change : std::uint8_t { None, Degraded, Recovered };

  /// @pre `bound` is positive
  explicit LatencyWatch(Duration bound) : bound_(bound) {}

  /// Returns whether a probe should be sent now: one is under way at a time.
  bool probe_due(TimePoint now) const { return !sent_ && now >= next_; }
  /// Must be called when a probe is sent.
  void sent(TimePoint now) { sent_ = now; }
  /// Must be called when the answer to the probe has come, after `round_trip`.
  Change answered(Duration round_trip, TimePoint now);
  /// Must be called when the probe has failed: it tells nothing.
  void failed(TimePoint now);
  /// Looks at a probe that is under way: one that takes longer than the bound counts at once.
  Change look(TimePoint now);

  bool degraded() const { return degraded_; }
  Duration bound() const { return bound_; }
  /// Returns the last round trip, or the age of a probe that takes longer; nullopt before the
  /// first.
  std::optional<Duration> round_trip() const { return round_trip_; }

 private:
  Change judge(Duration round_trip, TimePoint now);

  const Duration bound_;
  std::optional<TimePoint> sent_;
  TimePoint next_{};
  std::optional<Duration> round_trip_;
  bool degraded_ = false;
  /// Since when all probes contradict `degraded_`; nullopt when the last one does not.
  std::optional<TimePoint> otherwise_since_;
};

}  // namespace gecos::qos
