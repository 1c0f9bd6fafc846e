#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "gecos/session/process/pause_watch.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/status_grants.hpp"

namespace gecos::session {

/// The kind of thread that starts calls.
enum class Starter : std::uint8_t {
  Poller,  ///< runs short handlers itself
  Worker,  ///< a thread of the executor; runs short handlers itself
  Other,   ///< runs no handler: a user's thread, the maintenance thread, or a polling standby
};

/// Decides which queued call of one object starts next. Holds calls back until a pause of this
/// process is judged, until their clients send a heartbeat, and until the broker confirms the name
/// of the object. Not thread-safe: the object's mutex guards it.
class StartGate {
 public:
  StartGate(const ObjectSetup& setup, std::atomic<bool>& ready, const NameClaim& claim,
            const StatusGrants& statuses, ObjectCalls& calls)
      : setup_(setup), ready_(ready), claim_(claim), statuses_(statuses), calls_(calls) {}

  /// Removes the next call that may start from the queue and returns it; null when there is none.
  /// Marks the call as started if `starter` runs its handler itself. Ends calls that may no longer
  /// start.
  std::shared_ptr<ServerCall> next(Starter starter);
  /// Whether `call` may still start; ends the call when it may not.
  bool may_start(ServerCall& call);

  /// Holds the calls of `session` back until the next heartbeat of its client.
  void await_heartbeat(ServerSession& session);
  /// Must be called when a heartbeat came, or when none can come any more.
  void await_no_more(ServerSession& session);

 private:
  std::shared_ptr<ServerCall> take();

  const ObjectSetup& setup_;
  std::atomic<bool>& ready_;
  const NameClaim& claim_;
  const StatusGrants& statuses_;
  ObjectCalls& calls_;
  PauseWatch::Checked pause_;  ///< the last check for a pause
  std::size_t awaited_ = 0;    ///< sessions whose calls wait for a heartbeat
};

}  // namespace gecos::session
