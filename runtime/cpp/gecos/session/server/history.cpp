#include "gecos/session/server/history.hpp"

#include <algorithm>

#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::session {

void History::ended(Entry entry) {
  if (entry.text.size() > longest_text) {
    entry.text.resize(longest_text);
    while (!wire::valid_utf8(entry.text)) entry.text.pop_back();
  }
  if (entries_.size() < most_entries) {
    entries_.push_back(std::move(entry));
  } else {
    entries_[next_] = std::move(entry);
    next_ = (next_ + 1) % most_entries;
  }
}

const History::Entry* History::find(SessionId session, std::uint64_t counter) const {
  const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.session == session && entry.counter == counter;
  });
  return found == entries_.end() ? nullptr : &*found;
}

void History::opened(SessionId id, std::weak_ptr<ServerSession> session) {
  open_[id] = std::move(session);
}

std::shared_ptr<ServerSession> History::open(SessionId id) const {
  const auto found = open_.find(id);
  return found == open_.end() ? nullptr : found->second.lock();
}

void History::departed(SessionId id, const DuplicateWindow& arrived,
                       const std::shared_ptr<ServerSession>& lost) {
  open_.erase(id);
  if (departed_.size() == most_sessions) departed_.pop_front();
  if (lost) lost->replies->shrink();
  departed_.push_back({id, arrived, lost, lost ? lost->replies : nullptr});
  if (departed_.size() > most_lost) departed_[departed_.size() - 1 - most_lost].replies.reset();
}

const History::Departed* History::find_departed(SessionId id) const {
  const auto found = std::find_if(departed_.rbegin(), departed_.rend(),
                                  [&](const Departed& session) { return session.id == id; });
  return found == departed_.rend() ? nullptr : &*found;
}

std::optional<bool> History::had_arrived(SessionId id, std::uint64_t counter) const {
  const Departed* const known = find_departed(id);
  return known != nullptr ? std::optional(known->arrived.seen(counter)) : std::nullopt;
}

std::shared_ptr<ServerSession> History::session(SessionId id) const {
  if (auto session = open(id)) return session;
  const Departed* const known = find_departed(id);
  return known != nullptr ? known->session.lock() : nullptr;
}

const Bytes* History::reply(SessionId id, std::uint64_t counter) const {
  if (const auto session = open(id)) return session->replies->find(counter);
  const Departed* const known = find_departed(id);
  return known != nullptr && known->replies ? known->replies->find(counter) : nullptr;
}

}  // namespace gecos::session
