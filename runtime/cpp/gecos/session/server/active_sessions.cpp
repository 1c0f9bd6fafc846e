#include "gecos/session/server/active_sessions.hpp"

#include <algorithm>

namespace gecos::session {
namespace {

constexpr Duration stays_active = std::chrono::milliseconds(10);

}  // namespace

bool ActiveSessions::wake(const Session& session) {
  if (session->polled.active) return false;
  session->connection().woke();
  session->polled.active = true;
  session->polled.quiet_looks = 0;
  sessions_.push_back(session);
  return true;
}

void ActiveSessions::retire_idle(TimePoint now) {
  const auto idle = [&](const std::shared_ptr<ServerSession>& session) {
    if (session->polled.quiet_looks == 0) session->polled.last_heard = now;
    session->polled.quiet_looks = 1;
    if (session->gone.load()) return true;
    if (now - session->polled.last_heard < stays_active) return false;
    if (!session->connection().prepare_to_sleep()) {
      session->connection().woke();
      return false;
    }
    session->polled.active = false;
    return true;
  };
  sessions_.erase(std::remove_if(sessions_.begin(), sessions_.end(), idle), sessions_.end());
}

bool ActiveSessions::put_to_sleep(FunctionRef<void(const Session&)> part_if_lost) {
  for (const auto& session : sessions_) {
    session->polled.active = false;
    if (session->gone.load() || session->connection().prepare_to_sleep()) continue;
    session->connection().woke();
    part_if_lost(session);
    if (session->gone.load()) continue;
    session->polled.active = true;
    still_active_.push_back(session);
  }
  sessions_.swap(still_active_);
  still_active_.clear();
  return sessions_.empty();
}

/// Does not count a client that sleeps on another core, because such a client will not send
/// anything soon. Counts a client that sleeps on this core: a reply of this server may just have
/// woken that client, which then waits until this thread leaves the core.
media::Peers ActiveSessions::peers() const {
  const std::int32_t mine = running_core();
  bool here = false;
  bool elsewhere = false;
  bool unknown = false;
  for (const auto& session : sessions_) {
    const media::Whereabouts client = session->connection().peer_whereabouts();
    if (client.core == unknown_core) {
      unknown = true;
    } else if (client.core == mine) {
      here = true;
    } else if (!client.asleep) {
      elsewhere = true;
    }
  }
  if (elsewhere) return here || unknown ? media::Peers::Both : media::Peers::Elsewhere;
  if (here) return media::Peers::Here;
  return unknown ? media::Peers::Unknown : media::Peers::Elsewhere;
}

}  // namespace gecos::session
