#pragma once

#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"

namespace gecos::qos {

/// Judges whether the round trip of a connection stays within its bound. The connection becomes
/// degraded when every probe of the last `judged_after` exceeded the bound, and recovers when every
/// probe of the last `judged_after` stayed within the bound. Therefore a single slow answer changes
/// nothing, and two changes are at least `judged_after` apart. Reads no clock. Not thread-safe.
class LatencyWatch {
 public:
  static constexpr Duration judged_after = std::chrono::seconds(1);
  /// Time between two probes while the judgement does not change.
  static constexpr Duration usual_pause = std::chrono::seconds(1);
  /// Time between two probes while the latest probes contradict the judgement, which may therefore
  /// change.
  static constexpr Duration short_pause = std::chrono::milliseconds(100);

  enum class Change : std::uint8_t { None, Degraded, Recovered };

  /// @pre `bound` is positive
  explicit LatencyWatch(Duration bound) : bound_(bound) {}

  /// Returns whether a probe should be sent now. Only one probe at a time is under way.
  bool probe_due(TimePoint now) const { return !sent_ && now >= next_; }
  /// Must be called when a probe is sent.
  void sent(TimePoint now) { sent_ = now; }
  /// Must be called when the answer to the probe has come, after `round_trip`.
  Change answered(Duration round_trip, TimePoint now);
  /// Must be called when the probe has failed. A failed probe says nothing about the latency.
  void failed(TimePoint now);
  /// Checks the probe that is under way. If the probe already takes longer than the bound, it
  /// counts as too slow before its answer comes.
  Change look(TimePoint now);

  bool degraded() const { return degraded_; }
  Duration bound() const { return bound_; }
  /// Returns the last round trip. If the probe that is under way already takes longer than the
  /// bound, returns the age of this probe. Returns nullopt before the first result.
  std::optional<Duration> round_trip() const { return round_trip_; }

 private:
  Change judge(Duration round_trip, TimePoint now);

  const Duration bound_;
  std::optional<TimePoint> sent_;
  TimePoint next_{};
  std::optional<Duration> round_trip_;
  bool degraded_ = false;
  /// The time since which all probes contradict `degraded_`; nullopt if the last probe agrees with
  /// it.
  std::optional<TimePoint> otherwise_since_;
};

}  // namespace gecos::qos
