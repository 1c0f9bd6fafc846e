#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "gecos/base/clock.hpp"

namespace gecos::media {

/// Computes the age of packets from the sender's time stamps. The clocks of the two hosts may show
/// different times, but must run at the same rate. The computation assumes that the transit time of
/// the quickest packet is zero. Therefore an age is too small by this transit time, and is never
/// too large. Only one thread at a time may use a SendersClock.
class SendersClock {
 public:
  /// The assumed maximum drift between two clocks is one part in this number.
  static constexpr std::int64_t drift = 2000;
  /// The assumed maximum difference between two clocks, which is 73 years. A larger difference to
  /// the time stamp of a peer is reduced to this maximum.
  static constexpr Duration longest{std::int64_t{1} << 61};

  /// Returns the age of a packet that has the time stamp `sent_ns` and was read at the time `now`.
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

  /// Returns the time of our clock minus the time of the sender's clock, plus the shortest transit
  /// time of a packet. The result is the smallest difference between the arrival time and the send
  /// time of a packet in the last five to ten minutes. In this period, the clocks drift apart by
  /// less than the delay of a packet.
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

  std::optional<Duration> smallest_;  ///< smallest difference since begun_
  std::optional<Duration> before_;    ///< smallest difference in the previous period
  TimePoint begun_;
  std::optional<Duration> least_;  ///< difference of the clocks plus the shortest transit time
  TimePoint since_;
};

}  // namespace gecos::media
