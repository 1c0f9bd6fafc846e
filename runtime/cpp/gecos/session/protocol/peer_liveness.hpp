#pragma once

#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Judges by heartbeats whether the peer of a session is alive. Servers use it to judge their
/// clients, and clients use it to judge their server. Reads no clock: the caller passes the time of
/// a SuspendAwareClock, so that a peer does not count as silent while this process does not run.
/// Not thread-safe.
class PeerLiveness {
 public:
  struct Bounds {
    Duration suspect_after{};  ///< silence after which the peer may be dead
    Duration dead_after{};     ///< silence after which the peer counts as dead
  };
  enum class Verdict : std::uint8_t {
    Alive,    ///< a heartbeat arrived since the last check
    Quiet,    ///< no heartbeat arrived, but it is too early to judge
    Suspect,  ///< no heartbeat arrived for `suspect_after`
    Dead,     ///< no heartbeat arrived for `dead_after`
  };

  /// The silence of the peer is measured from the first `check`, or from an earlier call of
  /// `heard`.
  explicit PeerLiveness(Bounds bounds) : bounds_(bounds) {}

  /// Notes that the peer gave a sign of life other than a heartbeat.
  void heard(TimePoint now) { last_heard_ = now; }
  /// Ignores the first `heartbeats` heartbeats of the peer. Only later heartbeats count as signs of
  /// life.
  void await_heartbeat_after(std::uint64_t heartbeats) { heartbeats_ = heartbeats; }
  /// Judges the peer at the time `now`. `heartbeats`: number of heartbeats received so far.
  Verdict check(std::uint64_t heartbeats, TimePoint now);
  Duration silent_for(TimePoint now) const;

 private:
  const Bounds bounds_;
  std::uint64_t heartbeats_ = 0;  ///< number of heartbeats at the last check
  std::optional<TimePoint> last_heard_;
};

}  // namespace gecos::session
