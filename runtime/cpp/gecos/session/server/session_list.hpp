#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// The sessions of a server, by the key of their epoll events. Thread-safe. Functions that are
/// passed to this object run while its mutex is held, so they must not call this object.
class SessionList {
 public:
  using Session = std::shared_ptr<ServerSession>;

  /// Returns a key that no session has had so far; never 0.
  std::uint64_t new_key();
  void add(std::uint64_t key, Session session);
  /// Returns the session with this key; null when there is none.
  Session find(std::uint64_t key);
  std::vector<Session> all();
  void for_each(FunctionRef<void(const Session&)> use);
  /// Removes and returns the sessions that `which` selects.
  std::vector<Session> remove_if(FunctionRef<bool(const Session&)> which);

 private:
  Mutex mutex_;
  std::uint64_t next_key_ GECOS_GUARDED_BY(mutex_) = 1;
  std::unordered_map<std::uint64_t, Session> sessions_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
