#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/object_calls.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/suspend_aware_clock.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/session_standings.hpp"

namespace gecos::session {

/// Grants the actor and master status of one object on request, and ends a status when its holder
/// releases it, falls silent or is lost. When a status is lost, the commands issued under it end
/// too. Not thread-safe: the object's mutex guards it.
class StatusGrants {
 public:
  StatusGrants(const ObjectSetup& setup, const NameClaim& claim, ObjectCalls& calls);

  const access::LeaseTable& leases() const { return leases_; }
  /// Returns the current time by the clock of the leases. This clock does not advance while this
  /// process is suspended.
  TimePoint now() const { return clock_.now(); }
  /// Returns the state of this object that decides whether a call is admitted now.
  AdmittingObject admitting() const { return {setup_.name, leases_, clock_.now()}; }
  /// Returns the holders in the form in which clients see them.
  std::vector<Holder> holders() const;

  /// Replies to a request for a status. A request with `patience` waits while other clients hold
  /// the status. Any request also waits briefly while a handler still runs whose command was issued
  /// under a status that has ended, because two clients must not command the object at the same
  /// time.
  void request(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
               GecosObject_acquire_arguments asked);
  /// Returns the number of waiting requests before the request `counter` of `session`; nullopt when
  /// that request does not wait.
  std::optional<std::size_t> place_in_line(const ServerSession& session,
                                           std::uint64_t counter) const;
  /// Cancels the waiting request `counter` of `session`. Returns false when that request does not
  /// wait.
  bool cancel(ServerSession& session, std::uint64_t counter);
  /// Grants the waiting requests that can be granted now, in the order of their arrival. Must be
  /// called when a handler has returned. The functions below that end a status call it themselves.
  void serve_line();
  /// Refuses all waiting requests, because the server is about to end.
  void close();

  /// Keeps `session->standing` up to date until `depart`, because the session feeds inward streams.
  void note_feeder(const std::shared_ptr<ServerSession>& session);

  void renew(const ServerSession& session, TimePoint now) { leases_.renew(session.id(), now); }
  void release(ServerSession& session, const GecosObject_release_arguments& asked);
  /// Gives `session` sole command of the status that it shares: ends the commands of the other
  /// holders and refuses their later commands and samples, until `give_back` or until the status of
  /// `session` ends. Returns why not; nullopt when the session has taken over.
  std::optional<Failure> take_over(ServerSession& session);
  void give_back(ServerSession& session);
  /// Must be called when no command of `session` is open any more. Ends a status that the session
  /// has released.
  void commands_ended(SessionId session);
  /// Releases the status of `session`, however often the session acquired it. The status ends when
  /// the last command of the session has ended.
  void release_all(ServerSession& session);
  /// Must be called when the connection of `session` has ended. If the connection ended `in_order`,
  /// the status of the session ends with its last command, otherwise at once.
  void depart(ServerSession& session, bool in_order);
  /// Ends every status except the status of `by`, which gets a new epoch. Refuses all waiting
  /// requests, so that after a stop no program may command the object because of an earlier
  /// request.
  void stop(SessionId by, const std::string& why);
  /// Ends the status of holders that were silent for too long, and refuses requests that have
  /// waited for too long.
  void on_tick(TimePoint now);

 private:
  struct Request {
    std::shared_ptr<ServerSession> session;
    std::uint64_t counter = 0;
    GecosObject_acquire_arguments asked;
    TimePoint give_up{};
    std::optional<std::size_t> reported{};  ///< the number of earlier requests that was last sent
                                            ///< to the client
  };
  using Line = std::vector<Request>;

  Line::const_iterator find(const ServerSession& session, std::uint64_t counter) const;
  bool answer(const Request& request, std::size_t before);
  void end_line(const Failure& failure);
  void tell_places();
  void refuse_late(TimePoint now);
  void lose(SessionId session, const std::string& why);
  void note_standings() { standings_.note_change(leases_, clock_.now()); }

  const ObjectSetup& setup_;
  const NameClaim& claim_;
  ObjectCalls& calls_;
  access::LeaseTable leases_;
  SuspendAwareClock clock_;  ///< for leases and peer time-outs
  Line line_;                ///< the waiting requests, in order of arrival
  SessionStandings standings_;
};

}  // namespace gecos::session
