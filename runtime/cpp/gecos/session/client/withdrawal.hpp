#pragma once

#include <cstdint>
#include <string>

#include "gecos/command.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/client/ending.hpp"
#include "gecos/session/client/pending_command.hpp"

namespace gecos::session {

/// Withdraws the calls of a lost session in shared memory (start_words.hpp), and determines the
/// failure of each call: NOT_STARTED if the medium proves that the call did not start. Not
/// thread-safe.
class Withdrawal {
 public:
  explicit Withdrawal(media::Connection& connection) : connection_(connection) {}

  /// Tells the server in shared memory not to start any call up to the counter `last`. Returns
  /// false when client and server do not share memory; in this case, the caller must send a packet
  /// that withdraws the calls. Must be called before the program learns that any of the calls has
  /// failed.
  bool write(std::uint64_t last);

  /// Returns the failure of `command` after its session has ended. `how`: the way in which the
  /// session ended; `text`: the reason. If the session did not end in order, the withdrawal must be
  /// written or sent before this call.
  Failure failure_of(const PendingCommand& command, Ending how, const std::string& text) const;

 private:
  bool may_have_started(const PendingCommand& command, Ending how) const;

  media::Connection& connection_;
  bool written_ = false;  ///< the withdrawal was written to shared memory
};

}  // namespace gecos::session
