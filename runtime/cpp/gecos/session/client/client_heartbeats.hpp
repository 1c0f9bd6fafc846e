#pragma once

#include <algorithm>
#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/next_tick.hpp"

namespace gecos::session {

/// Says when a client sends its heartbeats. The sessions of a process share ticks, to save
/// wake-ups. In shared memory, a heartbeat may shift by up to 10 ms towards other work of the
/// process. Where heartbeats are packets, which wake the server as well, all sessions of the
/// process send theirs at the same times. Reads no clock. Not thread-safe.
class ClientHeartbeats {
 public:
  static constexpr Duration longest_shift = std::chrono::milliseconds(10);

  enum class Sent : std::uint8_t { InMemory, AsPackets };

  /// `origin`: heartbeats that are packets are sent a multiple of `period` after this time, which
  /// is the same for all sessions of a process.
  ClientHeartbeats(Duration period, Sent sent, TimePoint origin)
      : period_(period),
        shift_(sent == Sent::InMemory ? std::min(longest_shift, period / 10) : Duration{}),
        origin_(origin) {}

  /// Returns whether the client must send a heartbeat at the tick of the time `now`.
  bool due(TimePoint now) {
    if (now + 2 * shift_ < next_) return false;  // NextTick::shift explains the factor 2
    const bool in_step = shift_ == Duration{};
    next_ = in_step ? now + period_ - (now - origin_) % period_ : now + period_;
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
  const TimePoint origin_;
  TimePoint next_{};
};

}  // namespace gecos::session
