// The built-in operations of every object, whatever its interface: gecos::GecosObject.
#include <unistd.h>

#include <algorithm>

#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/wire/encodable.hpp"

namespace gecos::session {
namespace {

access::Status status_of(Status status) { return static_cast<access::Status>(status); }
Status status_of(access::Status status) { return static_cast<Status>(status); }

double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

std::string cut(std::string text, std::size_t longest) {
  while (text.size() > longest) text.pop_back();
  while (!wire::valid_utf8(text)) text.pop_back();
  return text;
}

Holder shown(const access::Holder& holder, TimePoint now) {
  Holder line;
  line.status = status_of(holder.status);
  line.user = cut(holder.client.user, 64);
  line.host = cut(holder.client.host, 64);
  line.program = cut(holder.client.program, 128);
  line.pid = holder.client.pid;
  line.held_for = seconds(now - holder.since);
  line.expires_in = std::max(0.0, seconds(holder.expires - now));
  line.releasing = holder.releasing;
  return line;
}

std::vector<Holder> shown(const std::vector<access::Holder>& roster, TimePoint now) {
  std::vector<Holder> lines;
  for (const auto& holder : roster) lines.push_back(shown(holder, now));
  return lines;
}

Failure undecodable(const wire::DecodeError& why) {
  return {Detail::BadParameter, why.message(), {}, {}};
}

/// Maximum time that a request for a status waits. Must be shorter than a client waits for a reply.
constexpr Duration longest_wait_for_status = std::chrono::seconds(1);
/// Maximum number of requests for a status that wait at one object. A correct client has one such
/// request at a time.
constexpr std::size_t most_waiting_for_status = 64;

Failure refusal(std::string reason, std::vector<Holder> holders) {
  StatusRefused refused;
  refused.reason = std::move(reason);
  refused.holders = std::move(holders);
  return {Detail::Fault, refused.reason, std::string(StatusRefused::type_name()),
          wire::to_bytes(refused)};
}

std::uint8_t number_of(Detail detail) { return static_cast<std::uint8_t>(detail); }

}  // namespace

void ObjectHost::answer_builtin(const std::shared_ptr<ServerSession>& session,
                                const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  if (log_enabled(LogLevel::Debug)) {
    log_debug("server", name_ + ": " + who(session->caller()) +
                            " calls the built-in operation with code " +
                            std::to_string(number(packet.header.code)));
  }
  using BuiltIn = GecosObjectInterface;
  const ByteView arguments = packet.body;
  const OperationDescription* const asked = BuiltIn::description.find(packet.header.code);
  if (asked == &BuiltIn::holders) return holders(*session, counter);
  if (asked == &BuiltIn::stop) return stop(*session, counter);
  if (asked == &BuiltIn::ping) return session->reply(counter, ByteView{});
  if (asked == &BuiltIn::describe) return describe(*session, counter);
  if (asked == &BuiltIn::acquire) return acquire(session, counter, arguments);
  if (asked == &BuiltIn::release) return release(*session, counter, arguments);
  if (asked == &BuiltIn::subscribe) return subscribe(*session, counter, arguments);
  if (asked == &BuiltIn::unsubscribe) return unsubscribe(*session, counter, arguments);
  if (asked == &BuiltIn::outcome) return outcome(*session, counter, arguments);
  session->reply(counter, Failure{Detail::UnknownOperation,
                                  "the built-in operation with code " +
                                      std::to_string(number(packet.header.code)) +
                                      " is newer than this server; update the server",
                                  {},
                                  {}});
}

void ObjectHost::holders(ServerSession& session, std::uint64_t counter) {
  const GecosObject_holders_result all{shown(leases_.roster(), lease_clock_.now())};
  session.reply(counter, wire::encoded(all));
}

void ObjectHost::describe(ServerSession& session, std::uint64_t counter) {
  Description about;
  about.name = name_;
  about.interface_name = interface_.name;
  about.version = interface_.version;
  about.interface_hash = interface_.hash;
  about.simulated = options_.simulated;
  about.presence = options_.simulated ? "not required (simulated)" : "not checked yet";
  about.authentication =
      session.connection().peer().uid ? "user and process, named by the kernel"
      : session.connection().capabilities().reach != media::Reach::Network
          ? "this process"
          : "key, proved by a handshake: " + session.connection().peer().description;
  about.epoch = number(leases_.epoch());
  about.queued = static_cast<std::uint32_t>(queue_.waiting().size());
  if (!queue_.running().empty()) about.executing = queue_.running().front()->operation.name;
  about.pid = getpid();
  about.registration = claim_.text();
  about.handlers = running_handlers();
  session.reply(counter, wire::encoded(GecosObject_describe_result{std::move(about)}));
}

void ObjectHost::acquire(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                         ByteView arguments) {
  auto asked = wire::decoded<GecosObject_acquire_arguments>(arguments);
  if (!asked) return session->reply(counter, undecodable(asked.error()));
  if (status_of(asked->wanted) == access::Status::Sensor) {
    return session->reply(counter,
                          Failure{Detail::BadParameter,
                                  "every client has sensor status: acquire actor or master status",
                                  {},
                                  {}});
  }
  Acquire what{asked->wanted, std::move(asked->password).value_or("")};
  if (outlives_its_status() == nullptr) return grant(*session, counter, what);
  if (waiting_.size() >= most_waiting_for_status) {
    return session->reply(
        counter, Failure{Detail::QueueFull,
                         name_ + ": " + std::to_string(waiting_.size()) +
                             " requests for a status already wait for a handler to end; try again",
                         {},
                         {}});
  }
  waiting_.push_back(
      {session, counter, std::move(what), runtime_->clock().now() + longest_wait_for_status});
}

void ObjectHost::grant(ServerSession& session, std::uint64_t counter, const Acquire& what) {
  if (claim_.standing() == NameClaim::Standing::Taken) {
    return session.reply(counter, refusal(name_ + ": " + claim_.text(), {}));
  }
  const TimePoint now = lease_clock_.now();
  const bool held_before = leases_.status_of(session.id()) != access::Status::Sensor;
  auto granted = leases_.acquire(session.id(), session.client(), status_of(what.wanted),
                                 access::plain_proof(what.password), now);
  if (log_enabled(LogLevel::Info)) {
    log_info("server", name_ + ": " + who(session.caller()) + (granted ? " has " : " is refused ") +
                           std::string(to_string(what.wanted)) + " status" +
                           (granted ? "" : ": " + granted.error().text));
  }
  if (granted) {
    if (!held_before) session.held_from = number(granted->epoch);
    const Grant given{status_of(granted->status), number(granted->epoch)};
    return session.reply(counter, wire::encoded(GecosObject_acquire_result{given}));
  }
  session.reply(counter,
                refusal(name_ + ": " + granted.error().text, shown(granted.error().holders, now)));
}

const ServerCall* ObjectHost::outlives_its_status() const {
  if (!leases_.roster().empty()) return nullptr;
  for (const QueueEntry* const entry : queue_.running()) {
    const auto& call = static_cast<const ServerCall&>(*entry);
    if (call.state.ended() && call.operation().status != access::Status::Sensor) return &call;
  }
  return nullptr;
}

void ObjectHost::grant_to_waiting() {
  if (waiting_.empty() || outlives_its_status() != nullptr) return;
  for (const auto& waiting : std::exchange(waiting_, {})) {
    grant(*waiting.session, waiting.counter, waiting.what);
  }
}

void ObjectHost::refuse_waiting(TimePoint now) {
  const ServerCall* const runs = outlives_its_status();
  if (runs == nullptr) return grant_to_waiting();
  std::erase_if(waiting_, [&](const WaitingForStatus& waiting) {
    if (now < waiting.give_up) return false;
    mutex_.assert_held();
    access::Holder last;
    last.client = runs->session->client();
    last.since = last.expires = lease_clock_.now();
    last.releasing = true;
    waiting.session->reply(
        waiting.counter,
        refusal(name_ + ": " + std::string(access::to_string(status_of(waiting.what.wanted))) +
                    " status refused: the handler of '" + std::string(runs->operation().name) +
                    "' still runs (issued by " + who(runs->caller()) +
                    "), although the status under which it was issued has ended; the handler "
                    "was told to end: try again",
                shown(std::vector{last}, lease_clock_.now())));
    return true;
  });
}

bool ObjectHost::waits_for_status(const ServerSession& session, std::uint64_t counter) const {
  return std::ranges::any_of(waiting_, [&](const WaitingForStatus& waiting) {
    return waiting.session.get() == &session && waiting.counter == counter;
  });
}

void ObjectHost::release(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  using Commands = access::LeaseTable::Commands;
  const auto asked = wire::decoded<GecosObject_release_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const bool now = asked->now;
  std::uint64_t epoch = asked->epoch;
  const std::uint64_t held_now = number(leases_.epoch());
  if (session.held_from <= epoch && epoch < held_now)
    epoch = held_now;  // `stop` calls of this session renewed its status
  if (now && Epoch{epoch} == leases_.epoch() &&
      leases_.status_of(session.id()) != access::Status::Sensor) {
    end_commands([&](const ServerCall& call) { return call.client == session.id(); },
                 Failure{Detail::Stopped, "its caller released the status at once", {}, {}});
  }
  leases_.release(session.id(), Epoch{epoch},
                  session.commands != 0 && !now ? Commands::Pending : Commands::None);
  if (log_enabled(LogLevel::Info)) {
    log_info("server", name_ + ": " + who(session.caller()) + " releases its status" +
                           (now ? ", and stops the commands issued under it" : ""));
  }
  session.reply(counter, ByteView{});
}

/// Takes effect at once, even if handlers hang, because it needs only the leases, the queue and the
/// interrupt flags.
void ObjectHost::stop(ServerSession& by, std::uint64_t counter) {
  const std::string why = "stopped by " + who(by.caller());
  log_info("server", name_ + ": " + why);
  leases_.stop(by.id(), why);
  const bool still_leased = leases_.status_of(by.id()) != access::Status::Sensor;
  end_commands([](const ServerCall&) { return true; }, Failure{Detail::Stopped, why, {}, {}});
  if (options_.on_stop) tell_user(options_.on_stop);
  by.reply(counter, ByteView{}, still_leased ? leases_.epoch() : Epoch{});
}

void ObjectHost::outcome(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  const auto asked = wire::decoded<GecosObject_outcome_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  OutcomeRecord record;
  if (asked->boot != number(process_incarnation())) {
    record = {number_of(Detail::OutcomeUnknown),
              "the server of " + name_ +
                  " was restarted after the call; it does not know the outcomes of earlier calls"};
  } else {
    record = outcome_of(SessionId{asked->session}, asked->counter);
  }
  session.reply(counter, wire::encoded(GecosObject_outcome_result{std::move(record)}));
}

OutcomeRecord ObjectHost::outcome_of(SessionId asked, std::uint64_t counter) {
  if (const auto* entry = outcomes_.find(asked, counter)) {
    return {number_of(entry->detail), entry->text};
  }
  const OutcomeRecord never{number_of(Detail::NotStarted),
                            "the call has not arrived, and does not start if it still arrives"};
  if (const auto session = outcomes_.open(asked)) {
    if (const auto* call = session->calls.find(counter)) {
      return {number_of((*call)->state.detail()), {}};
    }
    if (session->intake.is_aside(counter)) {
      return {number_of(Detail::Queued), "the call waits for calls that were issued earlier"};
    }
    if (!session->intake.seen(counter)) {
      if (!session->repeats()) return {number_of(Detail::Sent), "the call has not arrived yet"};
      if (session->intake.reject_late(counter) == ReceiveWindow::Verdict::Beyond) {
        return {number_of(Detail::Sent),
                "the call has not arrived, but may still start: it is too far ahead of a missing "
                "call; ask again"};
      }
      session->reply(counter, Failure{Detail::NotStarted, never.text, {}, {}});
      take_early(session);
      return never;
    }
  } else if (outcomes_.had_arrived(asked, counter) == std::optional(false)) {
    return never;
  }
  return {
      number_of(Detail::OutcomeUnknown),
      "the outcome is not known: the server keeps only the last outcomes of actor commands, and "
      "none of sensor operations"};
}

void ObjectHost::subscribe(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  const auto asked = wire::decoded<GecosObject_subscribe_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const StreamDescription* stream = interface_.find_stream(FunctionCode{asked->code});
  if (stream == nullptr) {
    return session.reply(counter,
                         Failure{Detail::UnknownOperation,
                                 name_ + " (" + std::string(interface_.name) +
                                     ") has no stream with code " + std::to_string(asked->code),
                                 {},
                                 {}});
  }
  const auto may =
      leases_.may_queue(session.id(), leases_.epoch(), stream->status, lease_clock_.now());
  if (!may) {
    return session.reply(counter, Failure{Detail::Denied,
                                          "stream '" + std::string(stream->name) + "' of " + name_ +
                                              " " + may.error().text,
                                          {},
                                          {}});
  }
  const auto shared = session.share(*stream);
  if (!shared) return session.reply(counter, Failure{Detail::Rejected, shared.error(), {}, {}});
  session.subscriptions[stream->code] = *shared;
  session.reply(counter, wire::encoded(GecosObject_subscribe_result{*shared}));
}

void ObjectHost::unsubscribe(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  const auto asked = wire::decoded<GecosObject_unsubscribe_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const auto found = session.subscriptions.find(FunctionCode{asked->code});
  if (found != session.subscriptions.end()) {
    session.unshare(found->second);
    session.subscriptions.erase(found);
  }
  session.reply(counter, ByteView{});
}

}  // namespace gecos::session
