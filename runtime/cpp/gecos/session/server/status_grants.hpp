#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/object_calls.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/suspend_aware_clock.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/password_check.hpp"
#include "gecos/session/server/roster_watch.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/session_standings.hpp"
#include "gecos/session/server/status_line.hpp"

namespace gecos::session {

/// Grants the actor and master status of one object on request, and ends a status when its holder
/// releases it, falls silent or is lost. When a status is lost, the commands issued under it end
/// too. This class has more methods than other classes, because each way in which a status begins
/// or ends is a method. Not thread-safe: the object's mutex guards it.
class StatusGrants {
 public:
  /// Derives the proof of a password on another thread.
  class Prover {
   public:
    /// Begins to derive the proof of `password`. When the proof is derived, the prover must call
    /// StatusGrants::proved. Returns false when no thread can be created for the work. Is not
    /// called while a proof is being derived.
    virtual bool prove(SessionId session, std::uint64_t counter, access::Proof password) = 0;

   protected:
    ~Prover() = default;
  };

  StatusGrants(const ObjectSetup& setup, const NameClaim& claim, ObjectCalls& calls,
               Prover& prover);

  const access::LeaseTable& leases() const { return leases_; }
  /// Returns the current time by the clock of the leases. This clock does not advance while this
  /// process is suspended.
  TimePoint now() const { return clock_.now(); }
  /// Advances the clock of the leases to `now`, a time of the system's clock. Returns the new time
  /// of the clock of the leases.
  TimePoint advance(TimePoint now) { return clock_.advance(now); }
  /// Returns whether a request for the status, or a question about requests or holders, waits.
  bool somebody_waits() const { return line_.somebody_waits() || roster_.somebody_waits(); }
  /// Returns the state of this object that decides whether a call is admitted now.
  AdmittingObject admitting() const { return {setup_.name, leases_, clock_.now()}; }
  /// Returns the part that tells clients who holds the status and how the holders change.
  RosterWatch& roster() { return roster_; }

  /// Replies to a request for a status. A request with `patience` waits while other clients hold
  /// the status. Any request also waits briefly while a handler still runs whose command was issued
  /// under a status that has ended, because two clients must not command the object at the same
  /// time. A request with a password also waits while its proof is derived, and later requests wait
  /// behind it.
  void request(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
               GecosObject_acquire_arguments asked);
  /// Continues the request `counter` of `session` when its proof has been derived. `proof`: nullopt
  /// when the proof could not be derived. Does nothing when the request no longer waits.
  void proved(SessionId session, std::uint64_t counter, std::optional<access::Proof> proof);
  /// Returns the waiting requests for the status.
  StatusLine& line() { return line_; }
  /// Grants the waiting requests that can be granted now, in the order of their arrival. Must be
  /// called when a handler has returned. The functions below that end a status call `serve_line`
  /// themselves.
  void serve_line();
  /// Refuses the waiting request with this id, because a holder of the status denies it. Returns
  /// false when no such request waits.
  bool deny(std::uint64_t id, const std::string& why);
  /// Called when the server is about to end. Refuses all waiting requests for the status, and
  /// replies to all clients that have asked who waits.
  void close();

  /// From now until `depart`, keeps `session->standing` up to date, because the session feeds
  /// inward streams.
  void note_feeder(const std::shared_ptr<ServerSession>& session);

  void renew(const ServerSession& session, TimePoint now) { leases_.renew(session.id(), now); }
  void release(ServerSession& session, const GecosObject_release_arguments& asked);
  /// Gives `session` sole command of the status that it shares: ends the commands of the other
  /// holders and refuses their later commands and samples, until `give_back` or until the status of
  /// `session` ends. Returns nullopt, or the failure when the session cannot take over.
  std::optional<Failure> take_over(ServerSession& session);
  void give_back(ServerSession& session);
  /// Must be called when no command of `session` is open any more. Ends a status that the session
  /// has released.
  void commands_ended(SessionId session);
  /// Releases the status of `session` completely, even if the session has acquired it several
  /// times. The status ends when the last command of the session has ended.
  void release_all(ServerSession& session);
  /// Must be called when the connection of `session` has ended. If the connection ended `in_order`,
  /// the status of the session ends with its last command, otherwise at once.
  void depart(ServerSession& session, bool in_order);
  /// Ends every status except the status of `by`, which gets a new epoch. Refuses all waiting
  /// requests, so that after a stop no program may command the object because of an earlier
  /// request.
  void stop(SessionId by, const std::string& why);
  /// Ends every status as lost, then grants the waiting requests that can be granted.
  void break_all(const std::string& why);
  /// Ends the status of holders that were silent for too long, and refuses requests that have
  /// waited for too long.
  void on_tick(TimePoint now);

 private:
  void prove(StatusRequest request, access::Proof password);
  void prove_next();
  void settle(SessionId session, std::uint64_t counter, std::optional<access::Proof> proof);
  std::optional<access::LeaseRefusal> too_many_wrong(ServerSession& session,
                                                     access::Status wanted) const;
  bool answer(StatusRequest& request, std::size_t before);
  tl::expected<access::Grant, access::LeaseRefusal> try_to_acquire(StatusRequest& request,
                                                                   std::size_t before,
                                                                   TimePoint now);
  void refuse_late(TimePoint now);
  void lose(const std::vector<SessionId>& sessions, const std::string& why);
  void note_change(std::string_view why_ended = {});

  const ObjectSetup& setup_;
  const NameClaim& claim_;
  ObjectCalls& calls_;
  access::LeaseTable leases_;
  SuspendAwareClock clock_;  ///< the clock for leases and peer time-outs
  StatusLine line_;
  RosterWatch roster_;
  Prover& prover_;
  bool proving_ = false;  ///< `prover_` derives a proof
  PasswordCheck passwords_;
  SessionStandings standings_;
};

}  // namespace gecos::session
