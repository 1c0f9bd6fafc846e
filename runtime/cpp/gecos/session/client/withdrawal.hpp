#pragma once

#include <cstdint>
#include <string>

#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/pending_command.hpp"

namespace gecos::session {

/// Withdraws the calls of a lost session in shared memory (start_words.hpp), and finds the failure
/// of each call: NOT_STARTED where the medium proves that the call did not start. Not thread-safe.
class Withdrawal {
 public:
  explicit Withdrawal(media::Connection& connection) : connection_(connection) {}

  /// Writes that the server must start no call up to counter `last` any more. Returns false when
  /// the medium has no shared words: then the withdrawal needs a packet. Must be called before any
  /// call is reported as lost.
  bool write(std::uint64_t last);

  /// How `command` ends when its session ended as `how` because of `text`. Must be called after the
  /// withdrawal is written or sent, unless the session ended in order.
  Failure failure_of(const PendingCommand& command, Ending how, const std::string& text) const;

 private:
  bool may_have_started(const PendingCommand& command, Ending how) const;

  media::Connection& connection_;
  bool written_ = false;  ///< the server starts no more calls of this session
};

}  // namespace gecos::session
