#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"

namespace gecos::media {

/// Tells how long packets have waited, from what the sender's clock said when each was sent. The
/// two clocks need only go at the same pace: the packet that took least is held to have taken
/// nothing, so an age is too small by what the quickest way takes, and never too large. One thread
/// at a time.
class SendersClock {
 public:
  /// What two clocks may drift apart: one part in so many.
  static constexpr std::int64_t drift = 2000;
  /// What two clocks are held to differ at most, 73 years: no number that a peer sends upsets us.
  static constexpr Duration longest{std::int64_t{1} << 61};

  /// How old a packet is that said `sent_ns` and was read at `now`.
  Duration age(std::int64_t sent_ns, TimePoint now) {
    const auto here = static_cast<std::uint64_t>(now.time_since_epoch().count());
    const Duration took =
        std::clamp(Duration(static_cast<std::int64_t>(here - static_cast<std::uint64_t>(sent_ns))),
                   -longest, longest);
    if (!least_ || took <= *least_ + (now - since_) / drift) {
      least_ = took;
      since_ = now;
      return Duration::zero();
    }
    return took - *least_ - (now - since_) / drift;
  }

 private:
  std::optional<Duration> least_;  ///< the difference of the clocks, and the quickest way
  TimePoint since_;
};

}  // namespace gecos::media
