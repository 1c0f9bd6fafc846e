#include "gecos/session/server/session_list.hpp"

#include <utility>

namespace gecos::session {

std::uint64_t SessionList::new_key() {
  const MutexLock lock(mutex_);
  return next_key_++;
}

void SessionList::add(std::uint64_t key, Session session) {
  const MutexLock lock(mutex_);
  sessions_.emplace(key, std::move(session));
}

SessionList::Session SessionList::find(std::uint64_t key) {
  const MutexLock lock(mutex_);
  const auto found = sessions_.find(key);
  return found == sessions_.end() ? nullptr : found->second;
}

std::vector<SessionList::Session> SessionList::all() {
  const MutexLock lock(mutex_);
  std::vector<Session> sessions;
  for (const auto& [key, session] : sessions_) sessions.push_back(session);
  return sessions;
}

void SessionList::for_each(FunctionRef<void(const Session&)> use) {
  const MutexLock lock(mutex_);
  for (const auto& [key, session] : sessions_) use(session);
}

std::vector<SessionList::Session> SessionList::remove_if(FunctionRef<bool(const Session&)> which) {
  const MutexLock lock(mutex_);
  std::vector<Session> removed;
  for (auto at = sessions_.begin(); at != sessions_.end();) {
    if (!which(at->second)) {
      ++at;
      continue;
    }
    removed.push_back(std::move(at->second));
    at = sessions_.erase(at);
  }
  return removed;
}

}  // namespace gecos::session
