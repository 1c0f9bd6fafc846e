#include "gecos/session/client/server_watch.hpp"

#include <algorithm>

#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {
namespace {

/// Returns the silences after which the server counts as UNREACHABLE and as dead. UNREACHABLE comes
/// two heartbeats before `lease_ttl`, so that commands end at most `grace` + `lease_ttl` after the
/// death of the server, including the time until the death is detected.
PeerLiveness::Bounds bounds_of_server(const LabOptions& options) {
  const Duration suspect =
      std::max(options.lease_ttl - 2 * options.heartbeat, 2 * options.heartbeat);
  return {.suspect_after = suspect, .dead_after = suspect + options.grace};
}

}  // namespace

ServerWatch::ServerWatch(const LabOptions& options, const Clock& clock)
    : clock_(clock),
      longest_gap_(options.heartbeat * 3 / 2),
      // The clock counts at most `lease_ttl` of the time between two checks, because a longer time
      // means that this process did not run. A lower limit would delay the detection of a dead
      // server on a busy machine. A lower limit is not necessary either, because all packets that
      // have arrived are read before a check.
      liveness_clock_(clock.now(), options.lease_ttl),
      liveness_(bounds_of_server(options)),
      answers_(options.lease_ttl, 2 * (options.lease_ttl + options.grace), liveness_clock_.now()),
      heard_at_(clock.since_boot()) {
  liveness_.heard(liveness_clock_.now());
}

PeerLiveness::Verdict ServerWatch::judge_heartbeats(std::uint64_t heartbeats, TimePoint now) {
  const auto verdict = liveness_.check(heartbeats, liveness_clock_.advance(now));
  if (verdict == PeerLiveness::Verdict::Quiet) return verdict;
  const bool silent = verdict != PeerLiveness::Verdict::Alive;
  if (!silent) heard_at_.store(clock_.since_boot(), std::memory_order_relaxed);
  if (silent && !unreachable()) silent_since_.store(clock_.now(), std::memory_order_relaxed);
  unreachable_.store(silent, std::memory_order_relaxed);
  return verdict;
}

TimePoint ServerWatch::next_look(TimePoint now) const {
  return silent_for() > longest_gap_ ? now + retry_after(1) : TimePoint::max();
}

}  // namespace gecos::session
