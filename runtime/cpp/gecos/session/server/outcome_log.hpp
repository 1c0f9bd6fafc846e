#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"
#include "gecos/session/protocol/receive_window.hpp"

namespace gecos::session {

class ServerSession;

/// What became of an object's actor commands, kept for callers that lost their connection before
/// they were told. Bounded: the last outcomes, the last sessions.
class OutcomeLog {
 public:
  struct Entry {
    SessionId session{};
    std::uint64_t counter = 0;
    Detail detail = Detail::OutcomeUnknown;
    std::string text;
  };
  OutcomeLog() { entries_.reserve(most_entries); }  // the end of a command does not wait for memory
  void ended(Entry entry);
  const Entry* find(SessionId session, std::uint64_t counter) const;

  void opened(SessionId id, std::weak_ptr<ServerSession> session);
  std::shared_ptr<ServerSession> open(SessionId id) const;
  /// It sends nothing any more: what has not arrived never starts. `lost`: itself, when its client
  /// may ask for its answers in another session.
  void closed(SessionId id, const ReceiveWindow& arrived,
              const std::shared_ptr<ServerSession>& lost);
  /// Open, or lost and with calls that have not ended.
  std::shared_ptr<ServerSession> session(SessionId id) const;
  /// How a call of a lost session was answered; null when that is not known, or not any more.
  const Bytes* reply(SessionId id, std::uint64_t counter) const;
  /// Whether `counter` arrived; nothing when the session is not known, or not any more.
  std::optional<bool> had_arrived(SessionId id, std::uint64_t counter) const;

 private:
  static constexpr std::size_t most_entries = 1024;
  static constexpr std::size_t most_sessions = 256;
  static constexpr std::size_t most_lost = 32;  ///< whose answers are kept
  static constexpr std::size_t longest_text = 256;

  struct Closed {
    SessionId id{};
    ReceiveWindow arrived;
    std::weak_ptr<ServerSession> session;
    std::shared_ptr<const ReplyCache> replies;  ///< null: they are not kept
  };
  const Closed* find_closed(SessionId id) const;

  std::vector<Entry> entries_;  ///< when it is full, the oldest is at next_
  std::size_t next_ = 0;
  std::map<SessionId, std::weak_ptr<ServerSession>> open_;
  std::deque<Closed> closed_;
};

}  // namespace gecos::session
