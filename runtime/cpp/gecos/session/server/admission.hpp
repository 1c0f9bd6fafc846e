#pragma once

#include <optional>
#include <string_view>

#include "gecos/access/lease_table.hpp"
#include "gecos/access/object_presence.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/servant.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_queue.hpp"

/// Admission control: decides whether a call may be queued, and later whether the call may start.
/// Pure functions; the caller passes the current time.
namespace gecos::session {

/// True when `operation` needs actor or master status and is not a safety operation. Calls of such
/// an operation may start only while the broker confirms the name of the object (NameClaim).
bool commands_the_object(const OperationDescription& operation);

/// A call that is to be admitted.
struct CallRequest {
  const OperationDescription& operation;
  SessionId session{};
  Epoch epoch{};                   ///< epoch of the status under which the call was issued
  std::uint64_t counter = 0;       ///< number of the call in the session
  const Caller* caller = nullptr;  ///< null: the caller is not known
};

/// The called object. `now`: the current time by the clock of the object's leases.
struct AdmittingObject {
  std::string_view name;
  const access::LeaseTable& leases;
  TimePoint now{};
};

/// Returns why `call` must not be queued; nullopt when it may be queued. Does not check the limits
/// of the queue, because ObjectQueue::push checks them. `closing`: the server is shutting down.
std::optional<Failure> refusal_to_queue(const CallRequest& call, const AdmittingObject& object,
                                        const NameClaim& claim, const ObjectQueue& queue,
                                        bool closing);

/// The state of the session from which a queued call came.
struct CallerState {
  bool gone = false;       ///< the connection of the session was lost
  bool withdrawn = false;  ///< the client withdrew all calls that have not started
  /// True if no heartbeat of the client has arrived since this process was suspended, or if the
  /// client has been silent for too long.
  bool unheard = false;
};

/// Returns why a queued call must not start; nullopt when it may start. The conditions are checked
/// again, because leases may have ended since the call was queued. `late`: if the call has missed
/// its deadline or its latest start, the result of not_in_time(); otherwise nullopt.
std::optional<Failure> refusal_to_start(const CallRequest& call, const AdmittingObject& object,
                                        const CallerState& caller, std::optional<Failure> late);

/// Returns true when calls of `operation` need a person in the zone of the object.
bool needs_presence(const OperationDescription& operation);

/// If calls of `operation` need a person and nobody is known to be present in the zone of `object`,
/// returns the failure with which such a call ends, because the call must neither be queued nor
/// start. Otherwise returns nullopt.
std::optional<Failure> refusal_for_absence(const OperationDescription& operation,
                                           std::string_view object,
                                           const access::ObjectPresence& presence,
                                           TimePoint since_boot);

/// Returns the failure of a call that did not start in time. If `missed_start` is true, the call
/// did not start within the `start_by` of its operation. Otherwise it did not start before its
/// deadline.
Failure not_in_time(const OperationDescription& operation, bool missed_start);

/// Converts `left`, the time until the deadline of a call, to the moment of the deadline. Returns
/// TimePoint::max(), which means no deadline, when `left` is not positive or is centuries long.
/// `since_boot`: the current time of Clock::since_boot.
TimePoint expiry(Duration left, TimePoint since_boot);

}  // namespace gecos::session
