#include "gecos/session/server/admission.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {
namespace {

Detail detail_of(access::Denial::Reason reason) {
  switch (reason) {
    case access::Denial::Reason::LeaseEnded:
      return Detail::LeaseLost;
    case access::Denial::Reason::Stopped:
      return Detail::Stopped;
    case access::Denial::Reason::Preempted:
      return Detail::Preempted;
    default:
      return Detail::Denied;
  }
}

Failure refused(Detail detail, const CallRequest& call, const AdmittingObject& object,
                const std::string& why) {
  return {detail,
          "'" + std::string(call.operation.name) + "' of " + std::string(object.name) + " " + why,
          {},
          {}};
}

/// If the program that sent `call` holds the status of the object in another session, returns
/// advice for this program; otherwise an empty text.
std::string through_other_proxy(const CallRequest& call, const access::LeaseTable& leases) {
  if (call.caller == nullptr) return {};
  const Caller& caller = *call.caller;
  const auto is_caller = [&](const access::Holder& holder) {
    return holder.session != call.session && holder.client.pid == caller.pid &&
           holder.client.host == caller.host && holder.client.user == caller.user;
  };
  if (!std::ranges::any_of(leases.roster(), is_caller)) return {};
  return "; another proxy of the same program holds the status: call through that proxy, or "
         "through a copy of that proxy object";
}

Failure denied(const access::Denial& denial, const CallRequest& call,
               const AdmittingObject& object) {
  return refused(detail_of(denial.reason), call, object,
                 denial.text + through_other_proxy(call, object.leases) +
                     named_request(call.session, call.counter));
}

/// Returns a text such as "0.5 ms".
std::string in_ms(Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%g ms",
                std::chrono::duration<double, std::milli>(duration).count());
  return text;
}

}  // namespace

bool commands_the_object(const OperationDescription& operation) {
  return operation.status != access::Status::Sensor && !operation.safety;
}

std::optional<Failure> refusal_to_queue(const CallRequest& call, const AdmittingObject& object,
                                        const NameClaim& claim, const ObjectQueue& queue,
                                        bool closing) {
  const OperationDescription& operation = call.operation;
  if (closing) {
    return refused(Detail::Rejected, call, object, "was not started: the server is about to end");
  }
  if (!operation.safety) {
    const auto may =
        object.leases.may_queue(call.session, call.epoch, operation.status, object.now);
    if (!may) return denied(may.error(), call, object);
  }
  if (claim.refuses() && commands_the_object(operation)) {
    return refused(Detail::NotStarted, call, object, "was not started: " + claim.text());
  }
  if (operation.on_new == OnNew::Reject && !queue.running().empty()) {
    return refused(Detail::Rejected, call, object,
                   "was not started: '" + std::string(queue.running().front()->operation.name) +
                       "' is running; wait until it has ended, or cancel it");
  }
  return std::nullopt;
}

std::optional<Failure> refusal_to_start(const CallRequest& call, const AdmittingObject& object,
                                        const CallerState& caller, std::optional<Failure> late) {
  if (caller.gone) {
    return Failure{Detail::NotStarted, "the call was not started: the caller was gone", {}, {}};
  }
  if (caller.withdrawn) {
    return Failure{
        Detail::NotStarted, "the call was not started: the caller had given the call up", {}, {}};
  }
  if (caller.unheard) {
    return Failure{Detail::NotStarted,
                   "the call was not started: its caller sent no heartbeat since the server was "
                   "suspended, or was silent for too long",
                   {},
                   {}};
  }
  if (late) return late;
  if (call.operation.safety) return std::nullopt;
  const auto may =
      object.leases.may_start(call.session, call.epoch, call.operation.status, object.now);
  if (may) return std::nullopt;
  return denied(may.error(), call, object);
}

bool needs_presence(const OperationDescription& operation) {
  return operation.presence && commands_the_object(operation);
}

std::optional<Failure> refusal_for_absence(const OperationDescription& operation,
                                           std::string_view object,
                                           const access::ObjectPresence& presence,
                                           TimePoint since_boot) {
  if (!needs_presence(operation) || presence.present(since_boot)) return std::nullopt;
  return Failure{Detail::PresenceLost,
                 "'" + std::string(operation.name) + "' of " + std::string(object) +
                     " was not started: " + presence.text(since_boot),
                 {},
                 {}};
}

Failure not_in_time(const OperationDescription& operation, bool missed_start) {
  const std::string name = "'" + std::string(operation.name) + "'";
  std::string why = "the deadline of " + name + " passed before the call started";
  if (missed_start) {
    why = name + " did not start within its start_by of " + in_ms(operation.quality.start_by);
  }
  return {Detail::Expired, why + "; the call was not carried out", {}, {}};
}

TimePoint expiry(Duration left, TimePoint since_boot) {
  if (left <= Duration{} || left >= TimePoint::max() - since_boot) return TimePoint::max();
  return since_boot + left;
}

}  // namespace gecos::session
