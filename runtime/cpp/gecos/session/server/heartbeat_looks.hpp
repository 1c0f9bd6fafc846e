#pragma once

#include <algorithm>
#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/maintenance.hpp"

namespace gecos::session {

/// The longest time by which a server advances or delays periodic work so that two pieces of work
/// share a tick.
inline constexpr Duration tick_window = Maintenance::calm_tick;

/// The time between two heartbeats of a client (docs/protocol.md), and the longest period of the
/// heartbeats of a server.
inline constexpr Duration heartbeat_period = std::chrono::milliseconds(100);

/// Says when a server looks for the next heartbeat of a client. A heartbeat in shared memory wakes
/// nobody, so the server must look for it, and each look wakes a thread.
///
/// If a look finds no heartbeat, the server looks again after `tick_window`. A heartbeat that such
/// a repeated look finds is at most `tick_window` old, so the next look is due one
/// `heartbeat_period` later. If the first look already finds a heartbeat, that heartbeat may be
/// older, so the next look is due `heartbeat_period` minus `tick_window` later. A client that sends
/// heartbeats regularly costs three looks in two periods, and each heartbeat is found within
/// `tick_window`. A heartbeat that was sent early (client_heartbeats.hpp) is found within twice
/// that time. Reads no clock. Not thread-safe.
class HeartbeatLooks {
 public:
  /// Records that the server has looked at the time `now`, and has found that the client has sent
  /// `heartbeats` heartbeats so far. Returns the time of the next look.
  TimePoint look(std::uint64_t heartbeats, TimePoint now) {
    const bool came = heartbeats != heartbeats_;
    if (!came && now + tick_window < due_) return due_;  // the tick was for something else
    const Duration after_heartbeat = in_vain_ ? heartbeat_period : heartbeat_period - tick_window;
    heartbeats_ = heartbeats;
    in_vain_ = !came;
    return due_ = now + (came ? after_heartbeat : tick_window);
  }

 private:
  std::uint64_t heartbeats_ = 0;
  bool in_vain_ = false;  ///< the last look found no heartbeat
  TimePoint due_{};
};

/// Says when a server sends its own heartbeats: if possible, in a tick in which the server also
/// looks for a heartbeat of a client. Reads no clock. Not thread-safe.
class OwnHeartbeats {
 public:
  /// Returns whether the tick at the time `now` sends a heartbeat. `period`: the longest time
  /// between two heartbeats. If a heartbeat waits for a look, this time may be up to `tick_window`
  /// longer.
  bool due(TimePoint now, Duration period) {
    if (now + Maintenance::tick < next_) return false;
    // After a tick without a look, the next heartbeat comes earlier, so that after some periods a
    // heartbeat and a look share a tick.
    const bool with_look = next_look_ == TimePoint::max() || now >= next_look_;
    next_ = now + (with_look ? period : std::max(period - tick_window, tick_window));
    return true;
  }
  /// Returns the time of the next tick. `next_look`: the time of the next look for a heartbeat of a
  /// client; TimePoint::max() if no look is due.
  TimePoint next_tick(TimePoint next_look) {
    next_look_ = next_look;
    return next_look <= next_ + tick_window ? next_look : next_;
  }

 private:
  TimePoint next_{};
  TimePoint next_look_ = TimePoint::max();
};

}  // namespace gecos::session
