#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "gecos/access/object_presence.hpp"
#include "gecos/session/process/pause_watch.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/status_grants.hpp"

namespace gecos::session {

/// The kind of thread that starts calls.
enum class Starter : std::uint8_t {
  Poller,  ///< the thread that polls; runs short handlers itself
  Worker,  ///< a worker thread of the object; runs short handlers itself
  Other,   ///< a thread that runs no handler: a user's, the maintenance or the standby thread
};

/// Decides which queued call of one object starts next. Does not let a call start while a pause of
/// this process is not judged, while a heartbeat of its client is awaited, while the broker has
/// not confirmed the name of the object, or while nobody is present in the object's zone. Not
/// thread-safe: the object's mutex guards it.
class StartGate {
 public:
  StartGate(const ObjectSetup& setup, std::atomic<bool>& ready, const NameClaim& claim,
            const access::ObjectPresence& presence, const StatusGrants& statuses,
            ObjectCalls& calls)
      : setup_(setup),
        ready_(ready),
        claim_(claim),
        presence_(presence),
        statuses_(statuses),
        calls_(calls) {}

  /// Removes the next call that may start from the queue and returns this call; null when no call
  /// may start. If the thread of kind `starter` runs the handler itself, marks the call as started.
  /// Ends calls that may no longer start.
  std::shared_ptr<ServerCall> next(Starter starter);
  /// Returns whether `call` may still start. Ends the call when it may not.
  bool may_start(ServerCall& call);

  /// Prevents the calls of `session` from starting, and the samples of `session` from being read,
  /// until the next heartbeat of the client.
  void await_heartbeat(ServerSession& session);
  /// Ends the wait that await_heartbeat() began. Must be called when a heartbeat arrived, or when
  /// no heartbeat can arrive any more.
  void await_no_more(ServerSession& session);

 private:
  std::shared_ptr<ServerCall> take();

  const ObjectSetup& setup_;
  std::atomic<bool>& ready_;
  const NameClaim& claim_;
  const access::ObjectPresence& presence_;
  const StatusGrants& statuses_;
  ObjectCalls& calls_;
  PauseWatch::Checked pause_;  ///< the last check for a pause
  std::size_t awaited_ = 0;    ///< number of sessions whose calls wait for a heartbeat
};

}  // namespace gecos::session
