// How a served object processes the packets of its clients.
#include <pwd.h>
#include <sys/random.h>

#include <algorithm>

#include "gecos/base/recycling_allocator.hpp"
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

std::string text_of(ObjectQueue::Full full, std::size_t bytes) {
  const auto calls = [](std::size_t most, const char* whose) {
    return std::to_string(most) + " calls of " + whose +
           " are queued already; wait until one of them has ended";
  };
  const auto room = [&](std::size_t most, const char* whose) {
    return "its arguments take " + std::to_string(bytes) + " bytes; with the arguments of " +
           whose + " open calls, this exceeds the limit of " + std::to_string(most) +
           " bytes; wait until one of these calls has ended";
  };
  switch (full) {
    case ObjectQueue::Full::Object:
      return calls(ObjectQueue::most_of_object, "all clients");
    case ObjectQueue::Full::Client:
      return calls(ObjectQueue::most_of_client, "this client");
    case ObjectQueue::Full::BytesOfObject:
      return room(ObjectQueue::most_bytes_of_object, "all clients'");
    case ObjectQueue::Full::BytesOfClient:
      return room(ObjectQueue::most_bytes_of_client, "this client's");
  }
  return {};
}

constexpr const char* not_started = "the call was not started: its caller had given it up";

SessionId new_session_id() {
  std::uint64_t id = 0;
  while (id == 0) {
    if (getrandom(&id, sizeof id, 0) != sizeof id) id = 0;
  }
  return SessionId{id};
}

/// The user according to the kernel if it is known, else the user that the client claims.
std::string user_of(const media::Peer& peer, const std::string& claimed) {
  if (!peer.uid) return claimed;
  passwd entry{};
  passwd* found = nullptr;
  char text[4096];
  if (getpwuid_r(*peer.uid, &entry, text, sizeof text, &found) != 0 || found == nullptr) {
    return "uid " + std::to_string(*peer.uid);
  }
  return entry.pw_name;
}

}  // namespace

void ObjectHost::take(const std::shared_ptr<ServerSession>& session, ByteView bytes) {
  const MutexLock lock(mutex_);
  take_packet(session, bytes);
}

std::shared_ptr<ServerCall> ObjectHost::take_and_start(
    const std::shared_ptr<ServerSession>& session, ByteView bytes, Starter starter) {
  const MutexLock lock(mutex_);
  take_packet(session, bytes);
  return ready() ? start_next(starter) : nullptr;
}

void ObjectHost::take_packet(const std::shared_ptr<ServerSession>& session, ByteView bytes) {
  const auto packet = wire::decode_packet(bytes);
  if (!packet) return;
  const auto& header = packet->header;
  if (header.kind == wire::PacketKind::Hello) return greet(session, *packet);
  // this server has only sessions of its own protocol version
  if (header.version != wire::packet_version) return;
  const bool theirs = session->greeted() && header.session == session->id();
  if (header.kind == wire::PacketKind::Goodbye) {
    if (theirs) {
      session->left = true;
      // A client that sent its Goodbye while this process was suspended may be dead by now.
      if (header.flags == withdraws || unheard_since_a_pause(*session)) withdraw(*session);
      release_all(*session);
    }
    return say_goodbye(*session, header.session, "the client asked for it");
  }
  if (!theirs || session->closed)
    return say_goodbye(*session, header.session, "the server does not know the session");

  if (session->repeats()) acknowledge(session, header.acknowledged);
  if (header.counter == 0) return;  // no call has counter 0: the packet is damaged or malicious
  switch (header.kind) {
    case wire::PacketKind::Call:
      return arrive(session, *packet);
    case wire::PacketKind::Cancel:
      return cancel(*session, header.counter);
    case wire::PacketKind::Query:
      return answer_again(*session, header.counter);
    default:
      return;  // a packet kind of a newer client
  }
}

void ObjectHost::acknowledge(const std::shared_ptr<ServerSession>& session, std::uint64_t counter) {
  session->replies->acknowledged(counter);
  if (session->intake.abandon_up_to(counter)) take_early(session);
}

void ObjectHost::greet(const std::shared_ptr<ServerSession>& session,
                       const wire::PacketView& packet) {
  const auto hello = wire::from_bytes<Hello>(packet.body);
  wire::PacketHeader header;
  const auto refuse = [&](const std::string& why) {
    header.kind = wire::PacketKind::Refused;
    header.flags = static_cast<std::int8_t>(Detail::Refused);
    const FailureBody body{why, {}, {}};
    session->send(header, wire::to_bytes(body));
  };
  if (packet.header.version != wire::packet_version) {
    return refuse("this server speaks version " + std::to_string(wire::packet_version) +
                  " of the session protocol and the client " +
                  std::to_string(packet.header.version) + "; update the older one");
  }
  if (!hello) return refuse("the greeting does not decode: " + hello.error().message());
  if (closed_) return refuse("the server is about to end");
  if (!interface_.is_a(hello->interface_name)) {
    return refuse(name_ + " is a " + std::string(interface_.name) + ", not a " +
                  hello->interface_name);
  }
  if (!session->greeted()) {
    Caller caller;
    caller.user = user_of(session->connection().peer(), hello->user);
    caller.host = hello->host;
    caller.program = hello->program;
    caller.pid = session->connection().peer().pid.value_or(hello->pid);
    caller.incarnation = hello->incarnation;
    const SessionId id = new_session_id();
    caller.session = number(id);
    session->greet(id, std::move(caller));
    session->intake.accept_within(hello->accept_within);
    session->liveness.heard(lease_clock_.now());
    outcomes_.opened(id, session);
    note_session(id, weak_from_this());
    if (log_enabled(LogLevel::Info)) log_arrival(name_, *session);
  }
  Welcome welcome{name_,
                  std::string(interface_.name),
                  {},
                  interface_.hash,
                  number(process_incarnation()),
                  static_cast<std::uint32_t>(ObjectQueue::most_of_object),
                  {}};
  welcome.bases.assign(interface_.bases.begin(), interface_.bases.end());
  if (hello->interface_hash != interface_.hash) {
    for (const OperationDescription* operation : interface_.all_operations()) {
      welcome.operations.push_back({operation->code, operation->hash});
    }
  }
  header.kind = wire::PacketKind::Welcome;
  session->send(header, wire::to_bytes(welcome));
}

/// True when packets read from the session may be older than a pause of this process.
bool ObjectHost::unheard_since_a_pause(const ServerSession& session) const {
  return session.awaited ||
         runtime_->maintenance().pauses().suspected(runtime_->clock().since_boot());
}

/// Ends the calls of `session` that have not started, because its client has given them up.
void ObjectHost::withdraw(ServerSession& session) {
  session.intake.withdraw();  // also stops calls that wait for a thread
  while (const auto counter = session.intake.first_aside()) {
    end_early(session, *counter, Detail::NotStarted, not_started);
  }
  std::vector<std::shared_ptr<ServerCall>> calls;
  for (const auto& [counter, call] : session.calls.all()) calls.push_back(call);
  for (const auto& call : calls) {
    if (call->state.queued()) end(*call, Failure{Detail::NotStarted, not_started, {}, {}});
  }
  note_ready();
}

void ObjectHost::say_goodbye(ServerSession& session, SessionId to, const std::string& why) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  header.session = to;
  session.send(header, goodbye_body(why));
}

void ObjectHost::arrive(const std::shared_ptr<ServerSession>& session,
                        const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  // Commands issued before a `release` still run, so the `release` counts as arrived only after all
  // of them.
  const bool release = packet.header.code == GecosObjectInterface::release.code;
  const bool unheard = session->awaited;
  const bool judged = session->intake.judges_age(unheard);
  switch (session->intake.arrived({.counter = counter,
                                   .age = judged ? session->connection().age() : Duration{},
                                   .unheard = unheard,
                                   .needs_all = release})) {
    case Intake::Verdict::Take:
      break;
    case Intake::Verdict::Seen:
      return answer_again(*session, counter);
    case Intake::Verdict::Ignore:
      return;
    case Intake::Verdict::TooLate:
      return refuse_late(*session, counter);
  }
  wire::PacketView aged = packet;
  if (Duration& left = aged.header.deadline; left > Duration{}) {
    left = std::max(left - session->connection().age(), Duration{1});
  }
  take_call(session, aged);
  take_early(session);
}

/// Refuses a call that was unread for too long, for example while this process was suspended. Its
/// client has reported OUTCOME_UNKNOWN, or queries the outcome again.
void ObjectHost::refuse_late(ServerSession& session, std::uint64_t counter) {
  const std::string why =
      "the call was not started: it was unread for more than " +
      std::to_string(session.intake.accepts_within() / std::chrono::milliseconds(1)) +
      " ms, because the server process or its machine did not run";
  outcomes_.ended({session.id(), counter, Detail::NotStarted, why});
  session.reply(counter, Failure{Detail::NotStarted, why, {}, {}});
}

void ObjectHost::take_call(const std::shared_ptr<ServerSession>& session,
                           const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  const FunctionCode code = packet.header.code;
  if (packet.header.flags == sent_again) return take_again(session, packet);
  if (is_builtin(code)) return answer_builtin(session, packet);
  const OperationDescription* operation = interface_.find(code);
  if (operation == nullptr) {
    return session->reply(
        counter, Failure{Detail::UnknownOperation,
                         name_ + " (" + std::string(interface_.name) + ", version " +
                             std::string(interface_.version) + ") has no operation with code " +
                             std::to_string(number(code)) +
                             "; its server is older than this client's interface",
                         {},
                         {}});
  }
  const std::size_t most =
      ObjectQueue::most_of_object + (operation->safety ? ObjectQueue::most_of_object / 4 : 0);
  // no correct client has so many calls in flight
  if (session->calls.size() + session->intake.aside() >= most) {
    return session->reply(counter,
                          Failure{Detail::QueueFull,
                                  "the client has more unanswered calls than the server granted",
                                  {},
                                  {}});
  }
  if (!too_early(*session, packet, *operation)) admit(session, packet, *operation);
}

/// A medium that loses packets may reorder commands. Defers a command that arrives before an
/// earlier command; otherwise an arm would move to its second goal first. Returns true when the
/// command was deferred, or refused for lack of room.
bool ObjectHost::too_early(ServerSession& session, const wire::PacketView& packet,
                           const OperationDescription& operation) {
  const bool keeps_place = operation.status != access::Status::Sensor || operation.ordered;
  if (operation.safety || !keeps_place || !session.intake.too_early(packet.header.counter)) {
    return false;
  }
  if (!session.intake.put_aside(packet, runtime_->clock().since_boot())) {
    const auto why = text_of(ObjectQueue::Full::BytesOfClient, packet.body.size());
    end_early(session, packet.header.counter, Detail::QueueFull,
              "the command was not queued: " + why);
  }
  return true;
}

void ObjectHost::end_early(ServerSession& session, std::uint64_t counter, Detail how,
                           const std::string& why) {
  session.intake.drop(counter);
  outcomes_.ended({session.id(), counter, how, why});
  session.reply(counter, Failure{how, why, {}, {}});
}

/// Processes the deferred calls for which no earlier call is missing any more.
void ObjectHost::take_early(const std::shared_ptr<ServerSession>& session) {
  if (session->intake.aside() == 0) return;
  const TimePoint now = runtime_->clock().since_boot();
  while (const auto call = session->intake.next(now)) {
    take_call(session, {call->header, call->body, {}});
  }
}

void ObjectHost::admit(const std::shared_ptr<ServerSession>& session,
                       const wire::PacketView& packet, const OperationDescription& operation) {
  const auto refuse = [&](const Failure& failure) {
    mutex_.assert_held();
    if (operation.status != access::Status::Sensor) {
      outcomes_.ended({session->id(), packet.header.counter, failure.detail, failure.text});
    }
    session->reply(packet.header.counter, failure);
    if (log_enabled(level_of(operation))) log_refused(name_, operation, session->caller(), failure);
  };
  if (const auto refusal = refusal_to_queue({operation, session->id(), packet.header.epoch},
                                            as_asked(), claim_, queue_, closed_)) {
    return refuse(*refusal);
  }
  auto call = make_recycled<ServerCall>(session, operation, packet.header.counter,
                                        packet.header.epoch, packet.body);
  if (log_enabled(level_of(operation))) call->arrived = runtime_->clock().now();
  if (packet.header.deadline > Duration{}) {
    call->state.set_deadline(expiry(packet.header.deadline, runtime_->clock().since_boot()));
  }
  if (const auto queued = queue_.push(call); !queued) {
    return refuse({Detail::QueueFull,
                   "'" + std::string(operation.name) + "' of " + name_ +
                       " was not queued: " + text_of(queued.error(), packet.body.size()),
                   {},
                   {}});
  }
  session->calls.insert(call->counter, call);
  ++session->unreturned;
  if (call->lane == CallLane::Actor) {
    ++session->commands;
    if (operation.on_new == OnNew::Preempt) preempt(*call);
    const auto position = queue_.position(*call).value_or(0);
    if (position != 0 || session->repeats() || runs_long(operation)) {
      call->position_sent = position;
      if (position != 0) session->report(*call, Detail::Queued, position);
    }
  }
  if (call->state.has_deadline()) list(*call);
  note_ready();
}

void ObjectHost::preempt(const ServerCall& by) {
  const Failure failure{Detail::Preempted,
                        "replaced by '" + std::string(by.operation().name) + "' of " +
                            by.caller().program + " (pid " + std::to_string(by.caller().pid) + ")",
                        {},
                        {}};
  end_commands([&](const ServerCall& other) { return &other != &by; }, failure);
}

void ObjectHost::answer_again(ServerSession& session, std::uint64_t counter) {
  if (const Bytes* kept = session.replies->find(counter)) return session.send_again(*kept);
  const auto* found = session.calls.find(counter);
  if (found == nullptr) {
    // Some queries are not answered. The call never arrived: the client sends it again. Its reply
    // was acknowledged: the query is late. The call is deferred or waits for a status: to its
    // caller it must appear as not arrived.
    if (session.intake.is_aside(counter) || waits_for_status(session, counter)) return;
    if (!session.intake.seen(counter) || !session.replies->awaited(counter)) return;
    return session.reply(counter,
                         Failure{Detail::OutcomeUnknown,
                                 "the call ended, but its reply was lost and is not kept any more:"
                                 " too many later replies were unacknowledged",
                                 {},
                                 {}});
  }
  const ServerCall& call = **found;
  session.report(call, call.state.detail(), queue_.position(call).value_or(0));
}

void ObjectHost::cancel(ServerSession& session, std::uint64_t counter) {
  if (session.intake.is_aside(counter)) {
    return end_early(session, counter, Detail::Canceled, "canceled before it started");
  }
  const auto* found = session.calls.find(counter);
  if (found == nullptr) return;
  const std::shared_ptr<ServerCall> call = *found;
  if (call->state.queued()) {
    end(*call, Failure{Detail::Canceled, "canceled before it started", {}, {}});
    note_ready();
  } else if (call->operation().cancelable && !call->state.canceling()) {
    call->state.on(CallState::Event::Cancel);
    interrupt(*call);
    session.report(*call, Detail::Canceling, 0);
    end_commands(
        [&](const ServerCall& other) {
          return other.client == call->client && other.state.queued() &&
                 other.counter > call->counter;
        },
        Failure{Detail::Canceled,
                "canceled, because an earlier command of the same client was canceled",
                {},
                {}});
    while (const auto later = session.intake.first_aside(counter)) {
      end_early(session, *later, Detail::Canceled,
                "canceled, because an earlier command of the same client was canceled");
    }
  }
}

}  // namespace gecos::session
