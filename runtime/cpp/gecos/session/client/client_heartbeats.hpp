#pragma once

#include <algorithm>
#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/next_tick.hpp"

namespace gecos::session {

/// Says when a client sends its heartbeats. In shared memory, a heartbeat may shift by up to 10 ms,
/// so that it shares a tick with other work. Over a medium that sends heartbeats as packets, the
/// sessions of a Lab send theirs in the same tick: a packet wakes the server too, and the packets
/// of one tick wake it once. Reads no clock. Not thread-safe.
class ClientHeartbeats {
 public:
  static constexpr Duration longest_shift = std::chrono::milliseconds(10);

  enum class Sent : std::uint8_t { InMemory, AsPackets };

  /// `anchor`: after the first heartbeat, which is sent at once, heartbeats that are packets are
  /// due at multiples of `period` after `anchor` (Runtime::heartbeat_anchor).
  ClientHeartbeats(Duration period, Sent sent, TimePoint anchor)
      : sent_(sent),
        period_(std::max(period, Duration{1})),
        shift_(sent == Sent::InMemory ? std::min(longest_shift, period / 10) : Duration{}),
        anchor_(anchor) {}

  /// Returns whether the client must send a heartbeat at the tick of the time `now`.
  bool due(TimePoint now) {
    if (now + 2 * shift_ < next_) return false;  // NextTick::shift explains the factor 2
    const Duration since_due = sent_ == Sent::AsPackets ? (now - anchor_) % period_ : Duration{};
    next_ = now + period_ - since_due;
    return true;
  }
  TimePoint next() const { return next_; }
  /// Returns when the next tick of the session is due: at the time `work`, at which other work of
  /// the session is due, or at the next heartbeat if that comes first.
  NextTick next_tick(TimePoint work) const {
    return work < next_ ? NextTick(work) : NextTick(next_, shift_);
  }

 private:
  const Sent sent_;
  const Duration period_;
  const Duration shift_;
  const TimePoint anchor_;
  TimePoint next_{};
};

}  // namespace gecos::session
