#pragma once

#include <optional>
#include <string_view>

#include "gecos/access/lease_table.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_queue.hpp"

/// Whether a call may be queued, and later whether it may start. Pure: time is passed in.
namespace gecos::session {

/// True when `operation` makes its object act. The object's name must then be confirmed
/// (NameClaim).
bool commands_the_object(const OperationDescription& operation);

/// A call that asks for admission.
struct CallRequest {
  const OperationDescription& operation;
  SessionId session{};
  Epoch epoch{};  ///< of the status under which it was issued
};

/// The object that is called; `now` is a time of its lease clock.
struct AdmittingObject {
  std::string_view name;
  const access::LeaseTable& leases;
  TimePoint now{};
};

/// Why `call` must not be queued; nullopt when it may be. ObjectQueue::push checks the bounds of
/// the queue. `closing`: the server is about to end.
std::optional<Failure> refusal_to_queue(const CallRequest& call, const AdmittingObject& object,
                                        const NameClaim& claim, const ObjectQueue& queue,
                                        bool closing);

/// The state of the session of a queued call.
struct CallerState {
  bool gone = false;       ///< its link was lost
  bool withdrawn = false;  ///< its client gave up all calls that have not started
  bool unheard = false;    ///< no heartbeat came since this process was suspended, or for too long
};

/// Why a queued call must not start; nullopt when it may. The conditions can have changed since it
/// was queued. `expired`: its deadline has passed.
std::optional<Failure> refusal_to_start(const CallRequest& call, const AdmittingObject& object,
                                        const CallerState& caller, bool expired);

/// The time, by the clock of `since_boot`, at which a call with `left` until its deadline expires.
/// TimePoint::max(), never, when `left` is zero or centuries.
TimePoint expiry(Duration left, TimePoint since_boot);

}  // namespace gecos::session
