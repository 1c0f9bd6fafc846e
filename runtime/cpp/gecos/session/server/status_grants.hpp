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

namespace gecos::session {

/// The actor and master status of one object: grants it on request, and ends it when its holder
/// releases it, falls silent or is lost. The commands issued under a status that is lost end with
/// it. Not thread-safe: the object's mutex guards it.
class StatusGrants {
 public:
  StatusGrants(const ObjectSetup& setup, const NameClaim& claim, ObjectCalls& calls);

  const access::LeaseTable& leases() const { return leases_; }
  /// The current time by the clock of the leases, which does not advance while this process is
  /// suspended.
  TimePoint now() const { return clock_.now(); }
  /// The state of this object by which a call is admitted now.
  AdmittingObject admitting() const { return {setup_.name, leases_, clock_.now()}; }
  /// The holders as clients see them.
  std::vector<Holder> holders() const;

  /// Replies to a request for a status. A request with `patience` waits in line while others hold
  /// the status. Any request waits briefly while the handler of a command still runs whose status
  /// has ended: two clients must not command the object at once.
  void request(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
               GecosObject_acquire_arguments asked);
  /// The number of requests before the request `counter` of `session`; nullopt when that request
  /// does not wait.
  std::optional<std::size_t> place_in_line(const ServerSession& session,
                                           std::uint64_t counter) const;
  /// Takes the request `counter` of `session` out of the line. Returns false when it does not wait.
  bool cancel(ServerSession& session, std::uint64_t counter);
  /// Grants the status to the requests that can have it now, in the order of their arrival. Must be
  /// called when a handler has returned; the functions below that end a status call it.
  void serve_line();
  /// Refuses the requests that wait: the server is about to end.
  void close();

  void renew(const ServerSession& session, TimePoint now) { leases_.renew(session.id(), now); }
  void release(ServerSession& session, const GecosObject_release_arguments& asked);
  /// Must be called when no command of `session` is open any more: a status that it has released
  /// ends.
  void commands_ended(SessionId session);
  /// Releases the status of `session` however often it was acquired; it ends with the last command.
  void release_all(ServerSession& session);
  /// The connection of `session` has ended. After `in_order` its status ends with its last command.
  void depart(ServerSession& session, bool in_order);
  /// Ends every status except that of `by`, which gets a new epoch, and the line: after a stop no
  /// program may command the object because it had asked before.
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
    std::optional<std::size_t> reported{};  ///< the place in line that its client knows
  };
  using Line = std::vector<Request>;

  Line::const_iterator find(const ServerSession& session, std::uint64_t counter) const;
  bool answer(const Request& request, std::size_t before);
  void end_line(const Failure& failure);
  void tell_places();
  const ServerCall* outlives_its_status() const;
  void refuse_late(TimePoint now);
  void lose(SessionId session, const std::string& why);

  const ObjectSetup& setup_;
  const NameClaim& claim_;
  ObjectCalls& calls_;
  access::LeaseTable leases_;
  SuspendAwareClock clock_;  ///< for leases and peer time-outs
  Line line_;                ///< in order of arrival
};

}  // namespace gecos::session
