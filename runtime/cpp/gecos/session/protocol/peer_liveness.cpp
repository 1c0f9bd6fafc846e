#include "gecos/session/protocol/peer_liveness.hpp"

namespace gecos::session {

PeerLiveness::Verdict PeerLiveness::check(std::uint64_t heartbeats, TimePoint now) {
  if (heartbeats != heartbeats_ || !last_heard_) {
    heartbeats_ = heartbeats;
    last_heard_ = now;
    return Verdict::Alive;
  }
  const Duration silent = silent_for(now);
  if (silent >= bounds_.dead_after) return Verdict::Dead;
  return silent >= bounds_.suspect_after ? Verdict::Suspect : Verdict::Quiet;
}

Duration PeerLiveness::silent_for(TimePoint now) const {
  return last_heard_ ? now - *last_heard_ : Duration::zero();
}

}  // namespace gecos::session
