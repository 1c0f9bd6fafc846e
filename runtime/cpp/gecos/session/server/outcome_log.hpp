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

/// The outcomes of an object's actor commands, kept for callers that lost their connection before
/// they were notified. Bounded: the last outcomes, the last sessions.
class OutcomeLog {
 public:
  struct Entry {
    SessionId session{};
    std::uint64_t counter = 0;
    Detail detail = Detail::OutcomeUnknown;
    std::string text;
  };
  OutcomeLog() { entries_.reserve(most_entries); }  // no reallocation when a command ends
  void ended(Entry entry);
  const Entry* find(SessionId session, std::uint64_t counter) const;

  void opened(SessionId id, std::weak_ptr<ServerSession> session);
  std::shared_ptr<ServerSession> open(SessionId id) const;
  /// The session receives no more packets: calls that have not arrived never start. `lost`: the
  /// session itself when its client may ask for its answers in another session, else null.
  void closed(SessionId id, const ReceiveWindow& arrived,
              const std::shared_ptr<ServerSession>& lost);
  /// The session if it is open, or lost with calls that have not ended; else null.
  std::shared_ptr<ServerSession> session(SessionId id) const;
  /// The reply to a call of a lost session; null when it is unknown or no longer kept.
  const Bytes* reply(SessionId id, std::uint64_t counter) const;
  /// Whether `counter` arrived in a closed session; nullopt when the session is unknown or no
  /// longer kept.
  std::optional<bool> had_arrived(SessionId id, std::uint64_t counter) const;

 private:
  static constexpr std::size_t most_entries = 1024;
  static constexpr std::size_t most_sessions = 256;
  static constexpr std::size_t most_lost = 32;  ///< lost sessions whose answers are kept
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
