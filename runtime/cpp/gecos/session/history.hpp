#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/ids.hpp"
#include "gecos/session/command.hpp"
#include "gecos/session/duplicates.hpp"

namespace gecos::session {

class ServerSession;

/// What became of an object's actor commands, kept for callers that lost their connection before
/// they were told. Bounded: the last outcomes, the last sessions.
class History {
 public:
  struct Entry {
    SessionId session{};
    std::uint64_t counter = 0;
    Detail detail = Detail::OutcomeUnknown;
    std::string text;
  };
  void ended(Entry entry);
  const Entry* find(SessionId session, std::uint64_t counter) const;

  void opened(SessionId id, std::weak_ptr<ServerSession> session);
  std::shared_ptr<ServerSession> open(SessionId id) const;
  /// It sends nothing any more: what has not arrived never starts.
  void departed(SessionId id, const DuplicateWindow& arrived);
  /// Whether `counter` arrived; nothing when the session is not known, or not any more.
  std::optional<bool> had_arrived(SessionId id, std::uint64_t counter) const;

 private:
  static constexpr std::size_t most_entries = 1024;
  static constexpr std::size_t most_sessions = 256;
  static constexpr std::size_t longest_text = 256;

  std::deque<Entry> entries_;
  std::map<SessionId, std::weak_ptr<ServerSession>> open_;
  std::deque<std::pair<SessionId, DuplicateWindow>> departed_;
};

}  // namespace gecos::session
