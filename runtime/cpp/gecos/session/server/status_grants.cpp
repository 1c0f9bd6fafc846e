#include "gecos/session/server/status_grants.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/wire/encodable.hpp"

namespace gecos::session {
namespace {

/// Maximum time that a request for a status waits. Must be shorter than a client waits for a reply.
constexpr Duration longest_wait = std::chrono::seconds(1);
/// Maximum number of requests for a status that wait at one object. A correct client has one such
/// request at a time.
constexpr std::size_t most_waiting = 64;

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

Failure refusal(std::string reason, std::vector<Holder> holders) {
  StatusRefused refused;
  refused.reason = std::move(reason);
  refused.holders = std::move(holders);
  return {Detail::Fault, refused.reason, std::string(StatusRefused::type_name()),
          wire::to_bytes(refused)};
}

}  // namespace

StatusGrants::StatusGrants(const ObjectSetup& setup, const NameClaim& claim, ObjectCalls& calls)
    : setup_(setup),
      claim_(claim),
      calls_(calls),
      leases_(process_incarnation(), setup.runtime->options().lease_ttl),
      clock_(setup.clock().now(), setup.runtime->options().heartbeat * 2) {}

std::vector<Holder> StatusGrants::holders() const { return shown(leases_.roster(), clock_.now()); }

// Requests

void StatusGrants::request(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                           GecosObject_acquire_arguments asked) {
  if (status_of(asked.wanted) == access::Status::Sensor) {
    return session->reply(counter,
                          Failure{Detail::BadParameter,
                                  "every client has sensor status: acquire actor or master status",
                                  {},
                                  {}});
  }
  if (outlives_its_status() == nullptr) return grant(*session, counter, asked);
  if (waiting_.size() >= most_waiting) {
    return session->reply(
        counter, Failure{Detail::QueueFull,
                         setup_.name + ": " + std::to_string(waiting_.size()) +
                             " requests for a status already wait for a handler to end; try again",
                         {},
                         {}});
  }
  waiting_.push_back({session, counter, std::move(asked), setup_.clock().now() + longest_wait});
}

void StatusGrants::grant(ServerSession& session, std::uint64_t counter,
                         const GecosObject_acquire_arguments& asked) {
  if (claim_.standing() == NameClaim::Standing::Taken) {
    return session.reply(counter, refusal(setup_.name + ": " + claim_.text(), {}));
  }
  const TimePoint now = clock_.now();
  const bool held_before = leases_.status_of(session.id()) != access::Status::Sensor;
  auto granted = leases_.acquire(session.id(), session.client(), status_of(asked.wanted),
                                 access::plain_proof(asked.password.value_or("")), now);
  if (log_enabled(LogLevel::Info)) {
    log_info("server", setup_.name + ": " + who(session.caller()) +
                           (granted ? " has " : " is refused ") +
                           std::string(to_string(asked.wanted)) + " status" +
                           (granted ? "" : ": " + granted.error().text));
  }
  if (granted) {
    if (!held_before) session.held_from = number(granted->epoch);
    const Grant given{status_of(granted->status), number(granted->epoch)};
    return session.reply(counter, wire::encoded(GecosObject_acquire_result{given}));
  }
  session.reply(counter, refusal(setup_.name + ": " + granted.error().text,
                                 shown(granted.error().holders, now)));
}

/// Returns a command that has ended for its caller while its handler continues; null when there is
/// no such command or a client holds a status. While it exists, no client may be granted a status.
const ServerCall* StatusGrants::outlives_its_status() const {
  if (!leases_.roster().empty()) return nullptr;
  for (const QueueEntry* const entry : calls_.queue().running()) {
    const auto& call = static_cast<const ServerCall&>(*entry);
    if (call.state.ended() && call.operation().status != access::Status::Sensor) return &call;
  }
  return nullptr;
}

bool StatusGrants::is_waiting(const ServerSession& session, std::uint64_t counter) const {
  return std::ranges::any_of(waiting_, [&](const Waiting& waiting) {
    return waiting.session.get() == &session && waiting.counter == counter;
  });
}

void StatusGrants::reply_to_waiting() {
  if (waiting_.empty() || outlives_its_status() != nullptr) return;
  for (const auto& waiting : std::exchange(waiting_, {})) {
    grant(*waiting.session, waiting.counter, waiting.asked);
  }
}

void StatusGrants::refuse_late(TimePoint now) {
  const ServerCall* const runs = outlives_its_status();
  if (runs == nullptr) return reply_to_waiting();
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    if (now < waiting.give_up) return false;
    access::Holder last;
    last.client = runs->session->client();
    last.since = last.expires = clock_.now();
    last.releasing = true;
    waiting.session->reply(
        waiting.counter,
        refusal(setup_.name + ": " +
                    std::string(access::to_string(status_of(waiting.asked.wanted))) +
                    " status refused: the handler of '" + std::string(runs->operation().name) +
                    "' still runs (issued by " + who(runs->caller()) +
                    "), although the status under which it was issued has ended; the handler "
                    "was told to end: try again",
                shown(std::vector{last}, clock_.now())));
    return true;
  });
}

void StatusGrants::close() {
  for (const auto& waiting : std::exchange(waiting_, {})) {
    waiting.session->reply(waiting.counter,
                           Failure{Detail::Rejected, "the server is about to end", {}, {}});
  }
}

// How a status ends

void StatusGrants::release(ServerSession& session, const GecosObject_release_arguments& asked) {
  using Commands = access::LeaseTable::Commands;
  std::uint64_t epoch = asked.epoch;
  const std::uint64_t held_now = number(leases_.epoch());
  if (session.held_from <= epoch && epoch < held_now)
    epoch = held_now;  // `stop` calls of this session renewed its status
  if (asked.now && Epoch{epoch} == leases_.epoch() &&
      leases_.status_of(session.id()) != access::Status::Sensor) {
    calls_.end_commands([&](const ServerCall& call) { return call.client == session.id(); },
                        Failure{Detail::Stopped, "its caller released the status at once", {}, {}});
  }
  leases_.release(session.id(), Epoch{epoch},
                  session.commands != 0 && !asked.now ? Commands::Pending : Commands::None);
  if (log_enabled(LogLevel::Info)) {
    log_info("server", setup_.name + ": " + who(session.caller()) + " releases its status" +
                           (asked.now ? ", and stops the commands issued under it" : ""));
  }
}

void StatusGrants::release_all(ServerSession& session) {
  using Commands = access::LeaseTable::Commands;
  while (leases_.status_of(session.id()) != access::Status::Sensor &&
         !leases_.releasing(session.id())) {
    leases_.release(session.id(), leases_.epoch(),
                    session.commands != 0 ? Commands::Pending : Commands::None);
  }
}

void StatusGrants::depart(ServerSession& session, bool in_order) {
  leases_.forget(session.id());
  std::erase_if(waiting_,
                [&](const Waiting& waiting) { return waiting.session.get() == &session; });
  if (in_order) return release_all(session);
  if (!leases_.lose(session.id())) return;
  lose(session.id(), "its holder (" + session.caller().program + ", pid " +
                         std::to_string(session.caller().pid) + ") is gone");
}

void StatusGrants::on_tick(TimePoint now) {
  for (const auto& holder : leases_.expire(clock_.advance(now))) {
    const auto ttl = setup_.runtime->options().lease_ttl / std::chrono::milliseconds(1);
    lose(holder.session, "its holder has been silent for " + std::to_string(ttl) + " ms");
  }
  if (!waiting_.empty()) refuse_late(now);
}

void StatusGrants::lose(SessionId session, const std::string& why) {
  log_info("server", setup_.name + ": a status ended: " + why);
  const Failure failure{
      Detail::LeaseLost, "the status under which the command was issued ended: " + why, {}, {}};
  calls_.end_commands(
      [&](const ServerCall& call) {
        return call.client == session && call.operation().status != access::Status::Sensor &&
               (call.state.queued() || call.operation().on_loss != OnLoss::Finish);
      },
      failure);
}

}  // namespace gecos::session
