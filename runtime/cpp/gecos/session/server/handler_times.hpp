#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Returns the weight of the time of one call's handler: the number of calls for which this time
/// counts. Returns 0 if the time need not be measured. `number`: the number of the call among the
/// calls of its operation, from 0. The first 16 calls are timed, then each 16th, because reading
/// the clock twice for each call would cost a tenth of a short call.
constexpr std::uint32_t timed_weight(std::uint64_t number) {
  if (number < 16) return 1;
  return number % 16 == 0 ? 16 : 0;
}

/// A histogram of the times of handlers on a logarithmic scale, from 128 ns to two hours, with four
/// buckets for each doubling. A quantile is at most a quarter too high. Not thread-safe.
class HandlerTimes {
 public:
  /// Adds `took`, the time of one handler that stands for `weight` handlers.
  void add(Duration took, std::uint32_t weight = 1);
  /// Returns the time that the share `share` of the handlers did not exceed; zero without handlers.
  /// @pre 0 < share <= 1
  Duration quantile(double share) const;
  Duration worst() const { return worst_; }

 private:
  static constexpr std::size_t of_octave = 4;
  static constexpr std::size_t octaves = 36;
  static constexpr int first_octave = 7;  ///< shorter times than 2^7 ns are in the first bucket

  static std::size_t bucket_of(Duration took);
  static Duration end_of(std::size_t bucket);

  std::array<std::uint64_t, of_octave * octaves> buckets_{};
  std::uint64_t count_ = 0;
  Duration worst_{};
};

}  // namespace gecos::session
