#pragma once

#include <cstdint>
#include <optional>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Whether the other side of a session lives, judged by its heartbeats alone. The server judges its
/// clients by it and the client its server. Time is passed in: that of a SuspendAwareClock, by
/// which a peer does not grow silent while this process does not run. Not thread-safe.
class PeerLiveness {
 public:
  struct Bounds {
    Duration suspect_after{};  ///< silence after which it may be dead
    Duration dead_after{};     ///< silence after which it counts as dead
  };
  enum class Verdict : std::uint8_t {
    Alive,    ///< a heartbeat came since the last check
    Quiet,    ///< none came, which means nothing yet
    Suspect,  ///< none came for `suspect_after`
    Dead,     ///< none came for `dead_after`
  };

  /// Silence counts from the first check, unless `heard` is called before it.
  explicit PeerLiveness(Bounds bounds) : bounds_(bounds) {}

  /// The peer gave a sign of life other than a heartbeat.
  void heard(TimePoint now) { last_heard_ = now; }
  /// Only a heartbeat after the first `heartbeats` ones counts as a sign of life.
  void await_heartbeat_after(std::uint64_t heartbeats) { heartbeats_ = heartbeats; }
  /// `heartbeats`: how many have come so far.
  Verdict check(std::uint64_t heartbeats, TimePoint now);
  Duration silent_for(TimePoint now) const;

 private:
  const Bounds bounds_;
  std::uint64_t heartbeats_ = 0;  ///< at the last check
  std::optional<TimePoint> last_heard_;
};

}  // namespace gecos::session
