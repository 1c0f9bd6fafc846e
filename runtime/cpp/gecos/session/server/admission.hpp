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

/// It makes its object act, so the object's name must be certain (NameClaim).
bool commands_the_object(const OperationDescription& operation);

/// A call that asks for admission.
struct CallRequest {
  const OperationDescription& operation;
  SessionId session{};
  Epoch epoch{};  ///< of the status under which it was issued
};

/// The object that is asked; `now` by the clock of its leases.
struct AdmittingObject {
  std::string_view name;
  const access::LeaseTable& leases;
  TimePoint now{};
};

/// Whether it may be queued as far as its object is concerned; the queue has bounds of its own.
/// Nothing: it may. `closing`: the server is about to end.
std::optional<Failure> refusal_to_queue(const CallRequest& call, const AdmittingObject& object,
                                        const NameClaim& claim, const ObjectQueue& queue,
                                        bool closing);

/// What has become of a call's session since it was queued.
struct CallerState {
  bool gone = false;       ///< its link was lost
  bool withdrawn = false;  ///< it has given up what has not started
  bool unheard = false;    ///< no heartbeat came since this process stood still, or for too long
};

/// Whether it may start: what was true when it was queued need not be true any more. Nothing: it
/// may. `expired`: its deadline has passed.
std::optional<Failure> refusal_to_start(const CallRequest& call, const AdmittingObject& object,
                                        const CallerState& caller, bool expired);

/// When a call expires that has `left`, by the clock of `since_boot`. Zero, and centuries, mean
/// never: TimePoint::max().
TimePoint expiry(Duration left, TimePoint since_boot);

}  // namespace gecos::session
