// Calls that a client sends again because it lost the session in which they were sent first.
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {

/// Processes a call that was first sent in a lost session. While the lost session is known, a
/// running call is reported in `session` and an ended call is answered again. A call that has not
/// arrived is barred in the lost session and starts as a new call in `session`.
void ObjectHost::take_again(const std::shared_ptr<ServerSession>& session,
                            const wire::PacketView& packet) {
  wire::Decoder from(packet.body);
  SentBefore sent;
  if (!sent.decode(from)) {
    return session->reply(packet.header.counter,
                          Failure{Detail::BadParameter, from.error().message(), {}, {}});
  }
  const SessionId lost{sent.session};
  wire::PacketView call = packet;
  call.header.flags = 0;
  call.body = packet.body.subspan(packet.body.size() - from.remaining());
  const OperationDescription* const operation = interface_.find(packet.header.code);
  if (operation == nullptr || !operation->idempotent || lost == session->id()) {
    return take_call(session, call);
  }
  if (const Bytes* const kept = outcomes_.reply(lost, sent.counter)) {
    if (const auto reply = wire::decode_packet(*kept)) {
      return session->reply_as(packet.header.counter, *reply);
    }
  }
  if (const auto before = outcomes_.session(lost)) {
    if (const auto* found = before->calls.find(sent.counter))
      return resume(session, packet, *found);
    reject_late(before, sent.counter);
  }
  take_call(session, call);
}

/// Makes `session` the session in which progress and outcome of `call` are reported.
void ObjectHost::resume(const std::shared_ptr<ServerSession>& session,
                        const wire::PacketView& packet, std::shared_ptr<ServerCall> call) {
  if (call->operation().code != packet.header.code) {
    return session->reply(
        packet.header.counter,
        Failure{Detail::BadParameter, "the call was sent before, with another operation", {}, {}});
  }
  if (call->resumed_in) call->resumed_in->calls.take(call->resumed_counter);
  call->resumed_in = session;
  call->resumed_counter = packet.header.counter;
  session->calls.insert(call->resumed_counter, call);
  session->report(*call, call->state.detail(), queue_.position(*call).value_or(0));
}

/// Keeps the call `counter` from starting if it still arrives in `before`, its first session.
void ObjectHost::reject_late(const std::shared_ptr<ServerSession>& before, std::uint64_t counter) {
  if (before->closed || !before->repeats()) return;
  if (before->intake.is_aside(counter)) {
    end_early(*before, counter, Detail::NotStarted, "the call was sent again in another session");
  } else if (before->intake.reject_late(counter) == ReceiveWindow::Verdict::New) {
    take_early(before);
  }
}

}  // namespace gecos::session
