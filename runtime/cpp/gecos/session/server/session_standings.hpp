#pragma once

#include <memory>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Keeps each session of one object informed about the epoch under which it has its status. The
/// ports of inward streams check each sample against this epoch. The replies to a holder of a
/// status contain this epoch when it has changed. Not thread-safe: the object's mutex guards it.
class SessionStandings {
 public:
  /// Must be called when `session` has been granted a status. The client knows the epoch of the
  /// status from the grant.
  void add_holder(const std::shared_ptr<ServerSession>& session);
  /// Must be called when `session` begins to feed inward streams. Keeps `session->standing` up to
  /// date until `remove`.
  void add_feeder(const std::shared_ptr<ServerSession>& session);
  void remove(const ServerSession& session);

  /// Must be called whenever a status or a take-over begins or ends.
  void note_change(const access::LeaseTable& leases, TimePoint now);
  /// Must be called when the epoch has risen although statuses continue. From then on, each reply
  /// to a holder contains the newer epoch.
  void note_newer_epoch(const access::LeaseTable& leases);

 private:
  // The pointers are weak, because a session owns its object, and the object owns these vectors.
  using Sessions = std::vector<std::weak_ptr<ServerSession>>;
  Sessions feeders_;
  Sessions holders_;  ///< also those that have lost their status
};

}  // namespace gecos::session
