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

/// Keeps the outcomes of an object's actor commands, for callers that lost their connection before
/// they received an outcome. Only the newest outcomes and the newest closed sessions are kept.
class OutcomeLog {
 public:
  struct Entry {
    SessionId session{};
    std::uint64_t counter = 0;
    Detail detail = Detail::OutcomeUnknown;
    std::string text;
  };
  OutcomeLog() { entries_.reserve(most_entries); }  // no reallocation when a command ends
  /// Records the end of a command. Keeps the first `longest_text` bytes of `text`.
  void ended(SessionId session, std::uint64_t counter, Detail detail, const std::string& text);
  const Entry* find(SessionId session, std::uint64_t counter) const;

  void opened(SessionId id, std::weak_ptr<ServerSession> session);
  std::shared_ptr<ServerSession> open(SessionId id) const;
  /// Returns the sessions that are open.
  std::vector<std::shared_ptr<ServerSession>> all_open() const;
  /// Must be called when the session `id` receives no more packets, so that calls that have not
  /// arrived will never start. `arrived`: which calls have arrived. `lost`: the session itself if
  /// its client may still request replies in another session, otherwise null.
  void closed(SessionId id, const ReceiveWindow& arrived,
              const std::shared_ptr<ServerSession>& lost);
  /// Returns the session `id` if it is open, or if it was lost and has calls that have not ended.
  /// Otherwise returns null.
  std::shared_ptr<ServerSession> session(SessionId id) const;
  /// Returns the reply that was sent to the call `counter` of session `id`, even if that session
  /// was lost since; null when the session is unknown or the reply is no longer kept.
  const Bytes* reply(SessionId id, std::uint64_t counter) const;
  /// Returns whether the call `counter` arrived in the closed session `id`; nullopt when the
  /// session is unknown or no longer kept.
  std::optional<bool> had_arrived(SessionId id, std::uint64_t counter) const;

 private:
  static constexpr std::size_t most_entries = 1024;
  static constexpr std::size_t most_sessions = 256;
  static constexpr std::size_t most_lost = 32;  ///< maximum number of lost sessions with replies
  static constexpr std::size_t longest_text = 256;

  struct Closed {
    SessionId id{};
    ReceiveWindow arrived;
    std::weak_ptr<ServerSession> session;
    std::shared_ptr<const ReplyCache> replies;  ///< null: the replies of this session are not kept
  };
  const Closed* find_closed(SessionId id) const;
  Entry& next_place();

  std::vector<Entry> entries_;  ///< a ring when full; next_ is then the index of the oldest entry
  std::size_t next_ = 0;
  std::map<SessionId, std::weak_ptr<ServerSession>> open_;
  std::deque<Closed> closed_;
};

}  // namespace gecos::session
