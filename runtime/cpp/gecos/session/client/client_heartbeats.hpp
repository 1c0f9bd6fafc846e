#pragma once

#include <algorithm>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/next_tick.hpp"

namespace gecos::session {

/// Says when a client sends its heartbeats. To save wake-ups, a heartbeat may shift by up to 10 ms
/// to share a tick with other work of the process, unless the medium sends heartbeats as packets.
/// Reads no clock. Not thread-safe.
class ClientHeartbeats {
 public:
  static constexpr Duration longest_shift = std::chrono::milliseconds(10);

  ClientHeartbeats(Duration period, bool may_shift)
      : period_(period), shift_(may_shift ? std::min(longest_shift, period / 10) : Duration{}) {}

  /// Returns whether the client must send a heartbeat at the tick of the time `now`.
  bool due(TimePoint now) {
    if (now + 2 * shift_ < next_) return false;  // NextTick::shift explains the factor 2
    next_ = now + period_;
    return true;
  }
  TimePoint next() const { return next_; }
  /// Returns when the next tick of the session is due: at the time `work`, at which other work of
  /// the session is due, or at the next heartbeat if that comes first.
  NextTick next_tick(TimePoint work) const {
    return work < next_ ? NextTick(work) : NextTick(next_, shift_);
  }

 private:
  const Duration period_;
  const Duration shift_;
  TimePoint next_{};
};

}  // namespace gecos::session
