#include "gecos/session/server/session_packets.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "gecos/base/log.hpp"
#include "gecos/base/recycling_allocator.hpp"
#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/greeting.hpp"
#include "gecos/session/server/presence_reports.hpp"
#include "gecos/session/server/visitor_calls.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

constexpr const char* not_started = "the call was not started: the caller had given the call up";

std::uint8_t number_of(Detail detail) { return static_cast<std::uint8_t>(detail); }

/// Records in the BlendChain of `session` that `call` has ended with `failure` without being
/// queued. Does nothing if the operation does not have @on_new("blend").
void note_failed(const ObjectSetup& setup, ServerSession& session, const wire::PacketHeader& call,
                 const Failure& failure) {
  const auto* const operation = setup.interface.find(call.code);
  if (operation == nullptr || operation->on_new != OnNew::Blend) return;
  session.chain.failed({call.counter, std::string(operation->name), failure.detail, failure.text});
}

/// Returns the arguments of the call in `packet`, whose flags are not 0. If the packet also reports
/// which failures the client has noticed, writes this report to `known`. Fails if the report is
/// malformed, or if the packet has flags of a later version, with which the body may have another
/// form.
tl::expected<ByteView, Failure> arguments_of(const wire::PacketView& packet, ChainReport& known) {
  const auto flags = packet.header.flags;
  if (flags < 0 || flags > stands_alone) {
    return tl::unexpected(Failure{Detail::BadParameter,
                                  "the call has the flags " + std::to_string(flags) +
                                      "; this server knows only the flags 0 to " +
                                      std::to_string(stands_alone) + "; update the server",
                                  {},
                                  {}});
  }
  if (flags != reports) return packet.body;
  wire::Decoder from(packet.body);
  if (!known.decode(from)) {
    known = {};
    return tl::unexpected(Failure{Detail::BadParameter, from.error().message(), {}, {}});
  }
  return packet.body.last(from.remaining());
}

/// Records in the BlendChain of `session` that the call in `packet` has arrived, and what the
/// client reports with the call. Returns the arguments of the call. Fails like `arguments_of`.
tl::expected<ByteView, Failure> note_arrival(ServerSession& session, const wire::PacketView& packet,
                                             const OperationDescription* operation) {
  const wire::PacketHeader& header = packet.header;
  ChainReport known;
  tl::expected<ByteView, Failure> arguments = packet.body;
  if (header.flags != 0) arguments = arguments_of(packet, known);
  if (operation != nullptr && commands_the_object(*operation)) {
    const bool under_it = number(header.epoch) >= session.held_from;
    session.chain.arrived(
        {header.counter, under_it ? session.held_from : 0, header.flags == stands_alone}, known);
  }
  return arguments;
}

/// Ends the running and waiting commands that the command `by` replaces.
void preempt(ObjectCalls& calls, const ServerCall& by) {
  const Failure failure{Detail::Preempted,
                        "replaced by '" + std::string(by.operation().name) + "' of " +
                            by.caller().program + " (pid " + std::to_string(by.caller().pid) + ")",
                        {},
                        {}};
  calls.end_commands([&](const ServerCall& other) { return &other != &by; }, failure);
}

}  // namespace

void SessionPackets::take(const Session& session, ByteView bytes) {
  const auto packet = wire::decode_packet(bytes);
  if (!packet) return;
  const auto& header = packet->header;
  if (header.kind == wire::PacketKind::Hello) {
    return greet(session, *packet, setup_, calls_.outcomes(), {statuses_.now(), closed_});
  }
  // The packet is ignored, because this server has only sessions of its own protocol version.
  if (header.version != wire::packet_version) return;
  const bool theirs = session->greeted() && header.session == session->id();
  if (header.kind == wire::PacketKind::Goodbye) {
    if (theirs) {
      session->left = true;
      // A client that has sent its Goodbye while this process was suspended may have died since.
      // Therefore its calls are withdrawn, too.
      if (header.flags == withdraws || unheard_since_a_pause(*session)) withdraw(*session);
      statuses_.release_all(*session);
    }
    return say_goodbye(*session, header.session, "the client ended the session");
  }
  if (!theirs || session->closed)
    return say_goodbye(*session, header.session, "the server does not know the session");

  if (session->repeats()) acknowledge(session, header.acknowledged);
  if (header.counter == 0) return;  // no call has counter 0: the packet is damaged or malicious
  switch (header.kind) {
    case wire::PacketKind::Call:
      return arrive(session, *packet);
    case wire::PacketKind::Cancel:
      return cancel(*session, header.counter, last_canceled(packet->body));
    case wire::PacketKind::Query:
      return answer_again(*session, header.counter);
    default:
      return;  // ignores a packet of a kind that only newer clients send
  }
}

void SessionPackets::depart(ServerSession& session) {
  // Each deferred call waits for an earlier call, which will not arrive any more.
  while (const auto counter = session.intake.first_aside()) {
    end_early(
        session, *counter, Detail::Rejected,
        "the call was not started: the session ended before the calls issued earlier arrived");
  }
}

void SessionPackets::acknowledge(const Session& session, std::uint64_t counter) {
  session->replies->acknowledged(counter);
  if (session->intake.abandon_up_to(counter)) take_early(session);
}

void SessionPackets::say_goodbye(ServerSession& session, SessionId to, const std::string& why) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  header.session = to;
  session.send(header, goodbye_body(why));
}

/// Returns true when packets that are read in the session may be older than a pause of this
/// process.
bool SessionPackets::unheard_since_a_pause(const ServerSession& session) const {
  return session.heartbeats.awaited || setup_.pauses().suspected(setup_.clock().since_boot());
}

/// Ends the calls of `session` that have not started, because the client has given them up.
void SessionPackets::withdraw(ServerSession& session) {
  session.intake.withdraw();  // so that calls that wait for a thread do not start either
  while (const auto counter = session.intake.first_aside()) {
    end_early(session, *counter, Detail::NotStarted, not_started);
  }
  std::vector<std::shared_ptr<ServerCall>> calls;
  for (const auto& [counter, call] : session.calls.all()) calls.push_back(call);
  for (const auto& call : calls) {
    if (call->state.queued()) calls_.end(*call, Failure{Detail::NotStarted, not_started, {}, {}});
  }
  calls_.note_ready();
}

/// Ends the call `counter` if it waits. Interrupts it if it runs, is cancelable and is not being
/// canceled. After an interruption, and after the end of a waiting command with @on_new("blend"),
/// also ends the later waiting commands of `session` up to the call `last`. After an interruption,
/// also interrupts the later commands with @on_new("blend") that the call has let start.
void SessionPackets::cancel(ServerSession& session, std::uint64_t counter, std::uint64_t last) {
  constexpr const char* before_start = "canceled before it started";
  const Failure left_line{Detail::Canceled, "canceled while the request waited", {}, {}};
  if (statuses_.line().end(session.id(), counter, left_line)) return;
  if (statuses_.roster().questions().end(session.id(), counter, left_line)) return;
  if (session.intake.is_aside(counter)) {
    const auto* const operation = setup_.interface.find(session.intake.code_aside(counter));
    end_early(session, counter, Detail::Canceled, before_start);
    if (operation == nullptr || operation->on_new != OnNew::Blend) return;
    session.chain.failed({counter, std::string(operation->name), Detail::Canceled, before_start});
    return cancel_later(session, counter, last);
  }
  const auto* found = session.calls.find(counter);
  if (found == nullptr) return;
  const std::shared_ptr<ServerCall> call = *found;
  if (call->state.queued()) {
    calls_.end(*call, Failure{Detail::Canceled, before_start, {}, {}});
    if (call->operation().on_new == OnNew::Blend) cancel_later(session, counter, last);
    calls_.note_ready();
  } else if (call->operation().cancelable && !call->state.canceling()) {
    cancel_running(session, *call);
    if (call->operation().on_new == OnNew::Blend) {  // for commands that still arrive
      session.chain.failed({counter, std::string(call->operation().name), Detail::Canceled,
                            "canceled while it was executing"});
    }
    for (const auto& [later, other] : session.calls.all()) {
      const bool after = later > counter && later <= last;
      if (after && call->lets_next && other->operation().on_new == OnNew::Blend) {
        cancel_running(session, *other);
      }
    }
    cancel_later(session, counter, last);
  }
}

/// Cancels the waiting commands of `session` that were issued after the command `counter`, up to
/// the command `last`.
void SessionPackets::cancel_later(ServerSession& session, std::uint64_t counter,
                                  std::uint64_t last) {
  const std::string why = "canceled, because an earlier command of the same client was canceled";
  calls_.end_commands(
      [&](const ServerCall& other) {
        return other.client == session.id() && other.state.queued() && other.counter > counter &&
               other.counter <= last;
      },
      Failure{Detail::Canceled, why, {}, {}});
  for (auto later = session.intake.first_aside(counter); later && *later <= last;
       later = session.intake.first_aside(*later)) {
    const auto* const operation = setup_.interface.find(session.intake.code_aside(*later));
    if (operation != nullptr && operation->on_new == OnNew::Blend) {
      session.chain.failed({*later, std::string(operation->name), Detail::Canceled, why});
    }
    end_early(session, *later, Detail::Canceled, why);
  }
}

void SessionPackets::cancel_running(ServerSession& session, ServerCall& call) {
  if (call.state.queued() || call.state.canceling() || call.state.ended()) return;
  call.state.on(CallState::Event::Cancel);
  calls_.interrupt(call);
  session.report(call, Detail::Canceling, 0);
}

void SessionPackets::answer_again(ServerSession& session, std::uint64_t counter) {
  if (const Bytes* kept = session.replies->find(counter)) return session.sender().send_again(*kept);
  if (const auto before = statuses_.line().place_of(session.id(), counter)) {
    session.report_queued(counter, *before);
    return;
  }
  if (statuses_.roster().questions().waits(session.id(), counter)) {
    session.report_queued(counter, 0);
    return;
  }
  const auto* found = session.calls.find(counter);
  if (found == nullptr) {
    // A query is not answered in three cases. If the call has never arrived, its client sends it
    // again. If the reply was acknowledged, the query came too late. If the call is deferred, its
    // client must not notice that the call has arrived.
    if (session.intake.is_aside(counter)) return;
    if (!session.intake.seen(counter) || !session.replies->awaited(counter)) return;
    return session.reply(counter,
                         Failure{Detail::OutcomeUnknown,
                                 "the call ended, but its reply was lost and is not kept any more:"
                                 " too many later replies were unacknowledged",
                                 {},
                                 {}});
  }
  const ServerCall& call = **found;
  session.report(call, call.state.detail(), calls_.queue().position(call).value_or(0));
}

// The functions below take a call from its arrival to the queue.

void SessionPackets::arrive(const Session& session, const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  // Commands that were issued before a `release` still run, so a `release` is accepted only after
  // all earlier calls have arrived.
  const bool release = packet.header.code == GecosObjectInterface::release.code;
  const Duration age = session->connection().age();
  // A `stop` over a medium that loses no packets takes effect however old it is. Over other media
  // an old packet is ignored, as that of any call.
  const bool stop = packet.header.code == GecosObjectInterface::stop.code;
  bool from_a_pause = !stop && session->intake.too_old(age);
  if (from_a_pause && !unheard_since_a_pause(*session)) {
    // In shared memory, a heartbeat is read before the calls that were sent earlier. So a heartbeat
    // after the pause does not show that this call was sent after the pause.
    from_a_pause = setup_.clock().since_boot() - age <= setup_.pauses().ended();
  }
  switch (session->intake.arrived(
      {.counter = counter, .age = age, .from_a_pause = from_a_pause, .needs_all = release})) {
    case Intake::Verdict::Take:
      break;
    case Intake::Verdict::Seen:
      return answer_again(*session, counter);
    case Intake::Verdict::Ignore:
      return;
    case Intake::Verdict::TooLate:
      return refuse_late(*session, packet);
  }
  wire::PacketView aged = packet;
  if (Duration& left = aged.header.deadline; left > Duration{}) {
    left = std::max(left - age, Duration{1});
  }
  take_call(session, aged, age);
  take_early(session);
}

/// Refuses a call that was unread for too long, for example while this process was suspended. The
/// client gives the call up soon, or has done so already. Therefore the call must not start.
void SessionPackets::refuse_late(ServerSession& session, const wire::PacketView& packet) {
  const wire::PacketHeader& call = packet.header;
  const std::string why =
      "the call was not started: it was unread for more than " +
      std::to_string(session.intake.accepts_within() / std::chrono::milliseconds(1)) +
      " ms, because the server process or its machine did not run";
  calls_.outcomes().ended(session.id(), call.counter, Detail::NotStarted, why);
  if (!is_builtin(call.code)) {
    const auto* const operation = setup_.interface.find(call.code);
    calls_.statistics().refused(session, operation, Detail::NotStarted);
    static_cast<void>(note_arrival(session, packet, operation));
    note_failed(setup_, session, call, {Detail::NotStarted, why, {}, {}});
  }
  session.reply(call.counter, Failure{Detail::NotStarted, why, {}, {}});
}

void SessionPackets::take_call(const Session& session, const wire::PacketView& packet,
                               Duration age) {
  const std::uint64_t counter = packet.header.counter;
  const FunctionCode code = packet.header.code;
  if (refuse_visitor(setup_, calls_.statistics(), *session, packet)) return;
  if (packet.header.flags == sent_again) return take_again(session, packet, age);
  if (is_builtin(code)) {
    if (log_enabled(LogLevel::Debug)) {
      log_debug("server", setup_.name + ": " + who(session->caller()) +
                              " calls the built-in operation with code " +
                              std::to_string(number(code)));
    }
    if (code == GecosObjectInterface::outcome.code) return answer_outcome(*session, packet);
    return builtin_.answer(session, packet);
  }
  const OperationDescription* operation = setup_.interface.find(code);
  if (operation == nullptr) {
    calls_.statistics().refused(*session, nullptr, Detail::UnknownOperation);
    return session->reply(
        counter,
        Failure{Detail::UnknownOperation,
                setup_.name + " (" + std::string(setup_.interface.name) + ", version " +
                    std::string(setup_.interface.version) + ") has no operation with code " +
                    std::to_string(number(code)) +
                    "; client and server were built from different versions of the interface",
                {},
                {}});
  }
  const std::size_t most =
      ObjectQueue::most_of_object + (operation->safety ? ObjectQueue::most_of_object / 4 : 0);
  // A correct client never has so many calls in flight.
  if (session->calls.size() + session->intake.aside() >= most) {
    calls_.statistics().refused(*session, operation, Detail::QueueFull);
    const Failure failure{
        Detail::QueueFull, "the client has more unanswered calls than the server granted", {}, {}};
    static_cast<void>(note_arrival(*session, packet, operation));
    note_failed(setup_, *session, packet.header, failure);
    return session->reply(counter, failure);
  }
  if (!too_early(*session, packet, *operation, age)) take_in_turn(session, packet, *operation, age);
}

/// Notes that a call has arrived, and admits it. All calls that must be admitted before this call
/// must have arrived.
void SessionPackets::take_in_turn(const Session& session, const wire::PacketView& packet,
                                  const OperationDescription& operation, Duration age) {
  wire::PacketView call = packet;
  const auto arguments = note_arrival(*session, packet, &operation);
  if (arguments) {
    call.body = *arguments;
    return admit(session, call, operation, age);
  }
  note_failed(setup_, *session, packet.header, arguments.error());
  session->reply(packet.header.counter, arguments.error());
}

void SessionPackets::admit(const Session& session, const wire::PacketView& packet,
                           const OperationDescription& operation, Duration age) {
  const auto refuse = [&](const Failure& failure, std::uint64_t because_of = 0) {
    if (operation.status != access::Status::Sensor) {
      calls_.outcomes().ended(session->id(), packet.header.counter, failure.detail, failure.text);
    }
    if (because_of == 0) note_failed(setup_, *session, packet.header, failure);
    session->reply(packet.header.counter, failure, because_of);
    calls_.statistics().refused(*session, &operation, failure.detail);
    setup_.audit->refused(*session, packet.header.counter, operation.code, operation.name, failure);
    if (log_enabled(level_of(operation)))
      log_refused(setup_.name, operation, session->caller(), failure);
  };
  if (const auto why = refusal(*session, packet, operation)) return refuse(*why);
  if (operation.on_new == OnNew::Blend && session->chain.broken()) {
    const std::string what = "'" + std::string(operation.name) + "' of " + setup_.name;
    if (const auto left_out = session->chain.left_out(packet.header.counter, what)) {
      return refuse(left_out->failure, left_out->because_of);
    }
  }
  auto made = make_recycled<ServerCall>(session, operation, packet.header.counter,
                                        packet.header.epoch, packet.body);
  ServerCall& call = *made;
  call.of_visitor = session->visit.visitor() != nullptr;
  if (log_enabled(level_of(operation))) call.arrived = setup_.clock().now();
  if (packet.header.deadline > Duration{}) {
    call.state.set_deadline(expiry(packet.header.deadline, setup_.clock().since_boot()));
  }
  if (const Duration start_by = operation.quality.start_by; start_by > Duration{}) {
    const Duration left = std::max(start_by - age, Duration{1});
    call.state.set_start_by(expiry(left, setup_.clock().since_boot()));
  }
  const auto commands_before = calls_.add(std::move(made));
  if (!commands_before) {
    return refuse({Detail::QueueFull,
                   "'" + std::string(operation.name) + "' of " + setup_.name +
                       " was not queued: " + text_of(commands_before.error(), packet.body.size()),
                   {},
                   {}});
  }
  if (call.lane != CallLane::Actor) return;
  if (operation.on_new == OnNew::Preempt) preempt(calls_, call);
  // A command that preempts others has just ended the commands before it, so the position of the
  // command is read from the queue.
  const auto position = *commands_before == 0 ? 0 : calls_.queue().position(call).value_or(0);
  if (position != 0 || session->repeats() || setup_.runs_long(operation)) {
    call.position_sent = position;
    if (position != 0) session->report(call, Detail::Queued, position);
  }
}

/// Returns why the call must not be queued; nullopt when it may be queued.
std::optional<Failure> SessionPackets::refusal(ServerSession& session,
                                               const wire::PacketView& packet,
                                               const OperationDescription& operation) {
  if (auto refusal = refusal_to_queue(
          {operation, session.id(), packet.header.epoch, packet.header.counter, &session.caller()},
          statuses_.admitting(), claim_, calls_.queue(), closed_)) {
    return refusal;
  }
  if (auto refusal = refusal_to_report(setup_, session, packet, operation)) return refusal;
  if (presence_.required()) {
    if (auto refusal =
            refusal_for_absence(operation, setup_.name, presence_, setup_.clock().since_boot())) {
      return refusal;
    }
  }
  return std::nullopt;
}

// The functions below handle calls that arrive before calls that were issued earlier.

/// A medium that loses packets may reorder commands. Defers a command that arrives before an
/// earlier command; otherwise an arm could move to its second goal first. Returns true when the
/// command was deferred, or was refused for lack of room.
bool SessionPackets::too_early(ServerSession& session, const wire::PacketView& packet,
                               const OperationDescription& operation, Duration age) {
  const bool keeps_place = operation.status != access::Status::Sensor || operation.ordered;
  if (operation.safety || !keeps_place || !session.intake.too_early(packet.header.counter)) {
    return false;
  }
  if (!session.intake.put_aside(packet, setup_.clock().since_boot(), age)) {
    const auto why = "the command was not queued: " +
                     text_of(ObjectQueue::Full::BytesOfClient, packet.body.size());
    calls_.statistics().refused(session, &operation, Detail::QueueFull);
    note_failed(setup_, session, packet.header, {Detail::QueueFull, why, {}, {}});
    end_early(session, packet.header.counter, Detail::QueueFull, why);
  }
  return true;
}

/// Processes those deferred calls for which all earlier calls have now arrived.
void SessionPackets::take_early(const Session& session) {
  if (session->intake.aside() == 0) return;
  const TimePoint now = setup_.clock().since_boot();
  while (const auto call = session->intake.next(now)) {
    take_call(session, {call->header, call->body, {}}, call->age);
  }
}

void SessionPackets::end_early(ServerSession& session, std::uint64_t counter, Detail how,
                               const std::string& why) {
  session.intake.drop(counter);
  calls_.outcomes().ended(session.id(), counter, how, why);
  session.reply(counter, Failure{how, why, {}, {}});
}

// The functions below handle calls that were first sent in a session that the client has lost.

/// Processes a call that was first sent in a lost session. If the server still knows the lost
/// session, there are three cases. A call that runs is from now on reported in `session`. A call
/// that has ended is answered again. A call that has not arrived becomes a new call in `session`,
/// and may no longer start in the lost session.
void SessionPackets::take_again(const Session& session, const wire::PacketView& packet,
                                Duration age) {
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
  const OperationDescription* const operation = setup_.interface.find(packet.header.code);
  // A visitor gets no replies of the lost session, because they may contain what a visitor must not
  // know.
  const bool visits = session->visit.visitor() != nullptr;
  if (operation == nullptr || !operation->idempotent || lost == session->id() || visits) {
    return take_call(session, call, age);
  }
  if (const Bytes* const kept = calls_.outcomes().reply(lost, sent.counter)) {
    if (const auto reply = wire::decode_packet(*kept)) {
      return session->reply_as(packet.header.counter, *reply);
    }
  }
  if (const auto before = calls_.outcomes().session(lost)) {
    if (const auto* found = before->calls.find(sent.counter))
      return resume(session, packet, *found);
    reject_late(before, sent.counter);
  }
  take_call(session, call, age);
}

/// From now on, reports the progress and the outcome of `call` in `session`.
void SessionPackets::resume(const Session& session, const wire::PacketView& packet,
                            std::shared_ptr<ServerCall> call) {
  if (call->operation().code != packet.header.code) {
    return session->reply(
        packet.header.counter,
        Failure{Detail::BadParameter, "the call was sent before, with another operation", {}, {}});
  }
  if (call->resumed_in) call->resumed_in->calls.take(call->resumed_counter);
  call->resumed_in = session;
  call->resumed_counter = packet.header.counter;
  session->calls.insert(call->resumed_counter, call);
  session->report(*call, call->state.detail(), calls_.queue().position(*call).value_or(0));
}

/// Makes sure that the call `counter` does not start if it still arrives in `before`, its first
/// session.
void SessionPackets::reject_late(const Session& before, std::uint64_t counter) {
  if (before->closed || !before->repeats()) return;
  if (before->intake.is_aside(counter)) {
    end_early(*before, counter, Detail::NotStarted, "the call was sent again in another session");
  } else if (before->intake.reject_late(counter) == ReceiveWindow::Verdict::New) {
    take_early(before);
  }
}

void SessionPackets::answer_outcome(ServerSession& session, const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  const auto asked = layout::from_bytes<GecosObject_outcome_arguments>(packet.body);
  if (!asked) {
    return session.reply(counter, Failure{Detail::BadParameter, asked.error().message(), {}, {}});
  }
  OutcomeRecord record;
  if (asked->boot != number(process_incarnation())) {
    record = {number_of(Detail::OutcomeUnknown),
              "the server of " + setup_.name +
                  " was restarted after the call; it does not know the outcomes of earlier calls"};
  } else {
    record = outcome_of(SessionId{asked->session}, asked->counter);
  }
  session.reply(counter, layout::to_bytes(GecosObject_outcome_result{std::move(record)}));
}

OutcomeRecord SessionPackets::outcome_of(SessionId asked, std::uint64_t counter) {
  if (const auto* entry = calls_.outcomes().find(asked, counter)) {
    return {number_of(entry->detail), entry->text};
  }
  const OutcomeRecord never{number_of(Detail::NotStarted),
                            "the call has not arrived, and will not start if it arrives later"};
  if (const auto session = calls_.outcomes().open(asked)) {
    if (const auto* call = session->calls.find(counter)) {
      return {number_of((*call)->state.detail()), {}};
    }
    if (session->intake.is_aside(counter)) {
      return {number_of(Detail::Queued), "the call waits for calls that were issued earlier"};
    }
    if (!session->intake.seen(counter)) {
      if (!session->repeats()) return {number_of(Detail::Sent), "the call has not arrived yet"};
      if (session->intake.reject_late(counter) == ReceiveWindow::Verdict::Beyond) {
        return {
            number_of(Detail::Sent),
            "the call has not arrived, but may still arrive and start, because earlier calls are "
            "missing, too; ask again"};
      }
      const Failure failure{Detail::NotStarted, never.text, {}, {}};
      session->chain.failed({counter, "a call that had not arrived", failure.detail, failure.text});
      session->reply(counter, failure);
      take_early(session);
      return never;
    }
  } else if (calls_.outcomes().had_arrived(asked, counter) == std::optional(false)) {
    return never;
  }
  return {
      number_of(Detail::OutcomeUnknown),
      "the outcome is not known: the server keeps only the last outcomes of actor commands, and "
      "none of sensor operations"};
}

}  // namespace gecos::session
