#pragma once

#include <memory>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Keeps the sessions of one object informed about their status. A session that feeds inward
/// streams needs it for the ports that read each sample; a session that holds a status needs it for
/// the replies to its client. Not thread-safe: the object's mutex guards it.
class SessionStandings {
 public:
  /// `session` has been granted a status, under an epoch that its client knows.
  void add_holder(const std::shared_ptr<ServerSession>& session);
  /// `session` feeds inward streams: keeps `session->standing` up to date until `remove`.
  void add_feeder(const std::shared_ptr<ServerSession>& session);
  void remove(const ServerSession& session);

  /// Must be called whenever a status or a take-over begins or ends.
  void note_change(const access::LeaseTable& leases, TimePoint now);
  /// Must be called when the epoch rose although statuses continue: from then on, each reply to a
  /// holder contains the newer epoch.
  void note_newer_epoch(const access::LeaseTable& leases);

 private:
  // Weak: a session owns its object, which owns this.
  using Sessions = std::vector<std::weak_ptr<ServerSession>>;
  Sessions feeders_;
  Sessions holders_;  ///< also those that have lost their status
};

}  // namespace gecos::session
