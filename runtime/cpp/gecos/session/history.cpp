#include "gecos/session/history.hpp"

#include <algorithm>

#include "gecos/wire/text.hpp"

namespace gecos::session {

void History::ended(Entry entry) {
  if (entry.text.size() > longest_text) {
    entry.text.resize(longest_text);
    while (!wire::valid_utf8(entry.text)) entry.text.pop_back();
  }
  if (entries_.size() == most_entries) entries_.pop_front();
  entries_.push_back(std::move(entry));
}

const History::Entry* History::find(SessionId session, std::uint64_t counter) const {
  const auto found = std::find_if(entries_.rbegin(), entries_.rend(), [&](const Entry& entry) {
    return entry.session == session && entry.counter == counter;
  });
  return found == entries_.rend() ? nullptr : &*found;
}

void History::opened(SessionId id, std::weak_ptr<ServerSession> session) {
  open_[id] = std::move(session);
}

std::shared_ptr<ServerSession> History::open(SessionId id) const {
  const auto found = open_.find(id);
  return found == open_.end() ? nullptr : found->second.lock();
}

void History::departed(SessionId id, const DuplicateWindow& arrived) {
  open_.erase(id);
  if (departed_.size() == most_sessions) departed_.pop_front();
  departed_.emplace_back(id, arrived);
}

std::optional<bool> History::had_arrived(SessionId id, std::uint64_t counter) const {
  const auto found = std::find_if(departed_.rbegin(), departed_.rend(),
                                  [&](const auto& session) { return session.first == id; });
  if (found == departed_.rend()) return std::nullopt;
  return found->second.seen(counter);
}

}  // namespace gecos::session
