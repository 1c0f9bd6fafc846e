#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "gecos/base/clock.hpp"

namespace gecos::media {

/// Computes the age of packets from the sender's time stamps. The two clocks need only run at the
/// same rate: the transit time of the quickest packet is taken as zero, so an age is too small by
/// that time, and never too large. One thread at a time.
class SendersClock {
 public:
  /// What two clocks may drift apart: one part in so many.
  static constexpr std::int64_t drift = 2000;
  /// The assumed maximum difference between two clocks, 73 years. Times sent by a peer are clamped
  /// to it.
  static constexpr Duration longest{std::int64_t{1} << 61};

  /// The age of a packet with the time stamp `sent_ns` that was read at `now`.
  Duration age(std::int64_t sent_ns, TimePoint now) {
    const auto here = static_cast<std::uint64_t>(now.time_since_epoch().count());
    const Duration took =
        std::clamp(Duration(static_cast<std::int64_t>(here - static_cast<std::uint64_t>(sent_ns))),
                   -longest, longest);
    note(took, now);
    if (!least_ || took <= *least_ + (now - since_) / drift) {
      least_ = took;
      since_ = now;
      return Duration::zero();
    }
    return took - *least_ - (now - since_) / drift;
  }

  /// How much later our clock reads, plus the shortest transit time: the smallest difference of the
  /// last five to ten minutes, in which clocks drift apart by less than packets are delayed.
  std::optional<Duration> difference() const {
    return before_ && smallest_ ? std::min(before_, smallest_) : smallest_;
  }

 private:
  static constexpr Duration period = std::chrono::minutes(5);
  void note(Duration took, TimePoint now) {
    if (smallest_ && now - begun_ >= period) before_ = std::exchange(smallest_, std::nullopt);
    if (!smallest_) begun_ = now;
    smallest_ = std::min(smallest_.value_or(took), took);
  }

  std::optional<Duration> smallest_;  ///< since begun_
  std::optional<Duration> before_;    ///< in the period before that
  TimePoint begun_;
  std::optional<Duration> least_;  ///< the difference of the clocks, and the quickest way
  TimePoint since_;
};

}  // namespace gecos::media
