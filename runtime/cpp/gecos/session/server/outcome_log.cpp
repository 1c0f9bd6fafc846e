#include "gecos/session/server/outcome_log.hpp"

#include <algorithm>

#include "gecos/session/server/server_session.hpp"
#include "gecos/wire/text.hpp"

namespace gecos::session {

void OutcomeLog::ended(SessionId session, std::uint64_t counter, Detail detail,
                       const std::string& text) {
  Entry& entry = next_place();
  entry.session = session;
  entry.counter = counter;
  entry.detail = detail;
  entry.text.assign(text, 0, longest_text);
  if (text.size() > longest_text) {
    while (!wire::valid_utf8(entry.text)) entry.text.pop_back();
  }
}

OutcomeLog::Entry& OutcomeLog::next_place() {
  if (entries_.size() < most_entries) return entries_.emplace_back();
  Entry& oldest = entries_[next_];
  next_ = (next_ + 1) % most_entries;
  return oldest;
}

const OutcomeLog::Entry* OutcomeLog::find(SessionId session, std::uint64_t counter) const {
  const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.session == session && entry.counter == counter;
  });
  return found == entries_.end() ? nullptr : &*found;
}

void OutcomeLog::opened(SessionId id, std::weak_ptr<ServerSession> session) {
  open_[id] = std::move(session);
}

std::shared_ptr<ServerSession> OutcomeLog::open(SessionId id) const {
  const auto found = open_.find(id);
  return found == open_.end() ? nullptr : found->second.lock();
}

std::vector<std::shared_ptr<ServerSession>> OutcomeLog::all_open() const {
  std::vector<std::shared_ptr<ServerSession>> all;
  for (const auto& [id, weak] : open_) {
    if (auto session = weak.lock()) all.push_back(std::move(session));
  }
  return all;
}

void OutcomeLog::closed(SessionId id, const ReceiveWindow& arrived,
                        const std::shared_ptr<ServerSession>& lost) {
  open_.erase(id);
  if (closed_.size() == most_sessions) closed_.pop_front();
  if (lost) lost->replies->shrink();
  closed_.push_back({id, arrived, lost, lost ? lost->replies : nullptr});
  if (closed_.size() > most_lost) closed_[closed_.size() - 1 - most_lost].replies.reset();
}

const OutcomeLog::Closed* OutcomeLog::find_closed(SessionId id) const {
  const auto found = std::find_if(closed_.rbegin(), closed_.rend(),
                                  [&](const Closed& session) { return session.id == id; });
  return found == closed_.rend() ? nullptr : &*found;
}

std::optional<bool> OutcomeLog::had_arrived(SessionId id, std::uint64_t counter) const {
  const Closed* const known = find_closed(id);
  return known != nullptr ? std::optional(known->arrived.seen(counter)) : std::nullopt;
}

std::shared_ptr<ServerSession> OutcomeLog::session(SessionId id) const {
  if (auto session = open(id)) return session;
  const Closed* const known = find_closed(id);
  return known != nullptr ? known->session.lock() : nullptr;
}

const Bytes* OutcomeLog::reply(SessionId id, std::uint64_t counter) const {
  if (const auto session = open(id)) return session->replies->find(counter);
  const Closed* const known = find_closed(id);
  return known != nullptr && known->replies ? known->replies->find(counter) : nullptr;
}

}  // namespace gecos::session
