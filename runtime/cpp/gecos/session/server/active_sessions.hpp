#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/media/waiting.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// The active sessions of a server: a thread polls their connections. The connections of all other
/// sessions of the server sleep: a packet on such a connection wakes the server through a
/// descriptor. Not thread-safe: used only by the thread that polls.
class ActiveSessions {
 public:
  using Session = std::shared_ptr<ServerSession>;

  bool empty() const { return sessions_.empty(); }
  std::size_t size() const { return sessions_.size(); }
  const Session& operator[](std::size_t at) const { return sessions_[at]; }

  /// Adds a new session, whose connection is polled from now on.
  void add(Session session) { sessions_.push_back(std::move(session)); }
  /// Adds `session` again. Must be called when the descriptor of its connection has reported a
  /// packet. Returns false when the connection is polled already.
  bool wake(const Session& session);
  /// Puts to sleep the connections that have been silent for a while.
  void retire_idle(TimePoint now);
  /// Puts all connections to sleep, except those on which a packet has arrived and those that are
  /// lost. Calls `part_if_lost` for each session whose connection does not sleep. Returns true when
  /// no active session is left.
  bool put_to_sleep(FunctionRef<void(const Session&)> part_if_lost);
  void clear() { sessions_.clear(); }

  /// Returns whether the clients that may send next run on this core, on other cores, or on both.
  media::Peers peers() const;

 private:
  std::vector<Session> sessions_;
  /// Used only by put_to_sleep. It is a member, so that put_to_sleep rarely allocates memory.
  std::vector<Session> still_active_;
};

}  // namespace gecos::session
