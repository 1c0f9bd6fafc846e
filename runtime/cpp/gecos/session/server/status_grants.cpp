#include "gecos/session/server/status_grants.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

/// How long a request for a status without patience waits for a handler to return.
constexpr Duration longest_wait_for_handler = std::chrono::seconds(1);
/// Maximum number of requests for a status that wait at one object. A correct client has one such
/// request at a time.
constexpr std::size_t longest_line = 64;

access::Status status_of(Status status) { return static_cast<access::Status>(status); }
Status status_of(access::Status status) { return static_cast<Status>(status); }

double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }
/// Converts seconds to a Duration. Returns about 30 years for longer times, including infinity.
Duration duration(double seconds) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(seconds, 1e9)));
}

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
  line.taken_over = holder.taken_over;
  if (holder.taken_over) line.taken_over_for = seconds(now - holder.taken_over_since);
  return line;
}

std::vector<Holder> shown(const std::vector<access::Holder>& roster, TimePoint now) {
  std::vector<Holder> lines;
  for (const auto& holder : roster) lines.push_back(shown(holder, now));
  return lines;
}

/// Returns the text that a refusal contains in addition when the request waited.
std::string waited_in_vain(double patience, std::size_t before) {
  if (patience <= 0) return {};
  char text[96];
  std::snprintf(text, sizeof text, "; the request waited %g s, with %zu request%s before it",
                patience, before, before == 1 ? "" : "s");
  return text;
}

Failure refusal(std::string reason, std::vector<Holder> holders) {
  StatusRefused refused;
  refused.reason = std::move(reason);
  refused.holders = std::move(holders);
  return {Detail::Fault, refused.reason, std::string(StatusRefused::type_name()),
          wire::to_bytes(refused)};
}

/// Refuses the request `counter` of `session` for the status `wanted`, and records this.
void refuse(const ObjectSetup& setup, ServerSession& session, std::uint64_t counter, Status wanted,
            const std::string& why, std::vector<Holder> holders) {
  setup.audit->status_refused(session, counter, to_string(wanted), why);
  session.reply(counter, refusal(setup.name + ": " + why + named_request(session.id(), counter),
                                 std::move(holders)));
}

/// Returns a command that still runs although the status under which it was issued has ended,
/// unless its interface lets it finish (`@on_loss("finish")`). Returns null when there is no such
/// command or when a client holds a status. While such a command runs, no client may be granted a
/// status.
const ServerCall* outlives_its_status(const access::LeaseTable& leases, const ObjectQueue& queue) {
  if (!leases.roster().empty()) return nullptr;
  for (const QueueEntry* const entry : queue.running()) {
    const auto& call = static_cast<const ServerCall&>(*entry);
    const bool finishes = call.operation().on_loss == OnLoss::Finish && !call.state.ended();
    if (call.operation().status != access::Status::Sensor && !finishes) return &call;
  }
  return nullptr;
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
  Duration patience = duration(asked.patience);
  const bool handler_runs = outlives_its_status(leases_, calls_.queue()) != nullptr;
  if (handler_runs) patience = std::max(patience, longest_wait_for_handler);
  Request request{session, counter, std::move(asked), setup_.clock().now() + patience};
  if (!handler_runs && answer(request, line_.size())) return;
  if (line_.size() >= longest_line) {
    return session->reply(counter,
                          Failure{Detail::QueueFull,
                                  setup_.name + ": " + std::to_string(line_.size()) +
                                      " requests for a status already wait; try again later",
                                  {},
                                  {}});
  }
  line_.push_back(std::move(request));
  tell_places();
}

/// Grants or refuses `request` and returns true, or returns false when the request must continue to
/// wait. `before`: the number of requests that wait before this request and could not be granted.
bool StatusGrants::answer(const Request& request, std::size_t before) {
  const auto& [session, counter, asked, give_up, reported] = request;
  if (claim_.standing() == NameClaim::Standing::Taken) {
    session->reply(counter, refusal(setup_.name + ": " + claim_.text(), {}));
    return true;
  }
  const TimePoint now = clock_.now();
  const access::Status wanted = status_of(asked.wanted);
  const bool held_before = leases_.status_of(session->id()) != access::Status::Sensor;
  // A client that has released the status must not get it again before the clients that wait for
  // it.
  const bool returns = before > 0 && leases_.releasing(session->id());
  auto granted = returns ? tl::unexpected(leases_.refusal_to_return(wanted, now))
                         : leases_.acquire(session->id(), session->client(), wanted,
                                           access::plain_proof(asked.password.value_or("")), now);
  if (!granted && setup_.clock().now() < give_up) return false;
  if (log_enabled(LogLevel::Info)) {
    log_info("server", setup_.name + ": " + who(session->caller()) +
                           (granted ? " has " : " is refused ") +
                           std::string(to_string(asked.wanted)) + " status" +
                           (granted ? "" : ": " + granted.error().text));
  }
  if (granted) {
    setup_.audit->status("status_granted", *session, counter, to_string(asked.wanted));
    if (!held_before) {
      session->held_from = number(granted->epoch);
      standings_.add_holder(session);
    }
    note_standings();
    const Grant given{status_of(granted->status), number(granted->epoch)};
    session->reply(counter, layout::to_bytes(GecosObject_acquire_result{given}));
  } else {
    refuse(setup_, *session, counter, asked.wanted,
           granted.error().text + waited_in_vain(asked.patience, before),
           shown(granted.error().holders, now));
  }
  return true;
}

StatusGrants::Line::const_iterator StatusGrants::find(const ServerSession& session,
                                                      std::uint64_t counter) const {
  return std::ranges::find_if(line_, [&](const Request& request) {
    return request.session.get() == &session && request.counter == counter;
  });
}

std::optional<std::size_t> StatusGrants::place_in_line(const ServerSession& session,
                                                       std::uint64_t counter) const {
  const auto found = find(session, counter);
  if (found == line_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - line_.begin());
}

bool StatusGrants::cancel(ServerSession& session, std::uint64_t counter) {
  const auto found = find(session, counter);
  if (found == line_.end()) return false;
  session.reply(counter, Failure{Detail::Canceled, "canceled while the request waited", {}, {}});
  line_.erase(found);
  tell_places();
  return true;
}

void StatusGrants::serve_line() {
  if (line_.empty() || outlives_its_status(leases_, calls_.queue()) != nullptr) return;
  std::size_t before = 0;
  std::erase_if(line_, [&](const Request& request) {
    if (answer(request, before)) return true;
    ++before;
    return false;
  });
  tell_places();
}

void StatusGrants::tell_places() {
  for (std::size_t before = 0; before < line_.size(); ++before) {
    Request& request = line_[before];
    if (request.reported == before) continue;
    if (request.session->report_queued(request.counter, before)) request.reported = before;
  }
}

void StatusGrants::refuse_late(TimePoint now) {
  const ServerCall* const runs = outlives_its_status(leases_, calls_.queue());
  if (runs == nullptr) return serve_line();
  std::erase_if(line_, [&](const Request& waiting) {
    if (now < waiting.give_up) return false;
    access::Holder last;
    last.client = runs->session->client();
    last.since = last.expires = clock_.now();
    last.releasing = true;
    refuse(setup_, *waiting.session, waiting.counter, waiting.asked.wanted,
           std::string(access::to_string(status_of(waiting.asked.wanted))) +
               " status refused: the handler of '" + std::string(runs->operation().name) +
               "' still runs (issued by " + who(runs->caller()) +
               "), although the status under which it was issued has ended; the handler was told "
               "to end: try again",
           shown(std::vector{last}, clock_.now()));
    return true;
  });
  tell_places();
}

void StatusGrants::end_line(const Failure& failure) {
  for (const auto& waiting : std::exchange(line_, {})) {
    waiting.session->reply(waiting.counter, failure);
  }
}

void StatusGrants::close() {
  end_line(Failure{Detail::Rejected, "the server is about to end", {}, {}});
}

// The end of a status

void StatusGrants::release(ServerSession& session, const GecosObject_release_arguments& asked) {
  using Commands = access::LeaseTable::Commands;
  std::uint64_t epoch = asked.epoch;
  const std::uint64_t held_now = number(leases_.epoch());
  if (session.held_from <= epoch && epoch < held_now)
    epoch = held_now;  // take-overs, and `stop` calls of this session, gave its status newer epochs
  if (asked.now && Epoch{epoch} == leases_.epoch() &&
      leases_.status_of(session.id()) != access::Status::Sensor) {
    calls_.end_commands(
        [&](const ServerCall& call) { return call.client == session.id(); },
        Failure{
            Detail::Stopped, "its caller released the status and stopped its commands", {}, {}});
  }
  if (leases_.status_of(session.id()) != access::Status::Sensor) {
    setup_.audit->status("status_released", session);
  }
  leases_.release(session.id(), Epoch{epoch},
                  session.commands != 0 && !asked.now ? Commands::Pending : Commands::None);
  note_standings();
  serve_line();
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
    setup_.audit->status("status_released", session);
  }
  note_standings();
  serve_line();
}

std::optional<Failure> StatusGrants::take_over(ServerSession& session) {
  const TimePoint now = clock_.now();
  if (const auto taken = leases_.take_over(session.id(), now); !taken) {
    return refusal(setup_.name + ": " + taken.error().text, shown(taken.error().holders, now));
  }
  log_info("server", setup_.name + ": " + who(session.caller()) + " takes over");
  setup_.audit->status("taken_over", session);
  note_standings();
  standings_.note_newer_epoch(leases_);  // before the ends of commands, which tell the epoch
  calls_.end_commands(
      [&](const ServerCall& call) {
        return call.client != session.id() && commands_the_object(call.operation());
      },
      Failure{Detail::Preempted, who(session.caller()) + " has taken over", {}, {}});
  return std::nullopt;
}

void StatusGrants::give_back(ServerSession& session) {
  if (!leases_.give_back(session.id())) return;
  note_standings();
  log_info("server", setup_.name + ": " + who(session.caller()) + " gives back");
  setup_.audit->status("given_back", session);
}

void StatusGrants::commands_ended(SessionId session) {
  const bool releases = leases_.releasing(session);
  leases_.drained(session);
  if (releases) note_standings();
  serve_line();
}

void StatusGrants::stop(SessionId by, const std::string& why) {
  end_line(
      Failure{Detail::Stopped, "the request for the status ended while it waited: " + why, {}, {}});
  for (const auto& holder : leases_.roster()) {
    if (holder.session != by) setup_.audit->status_lost(holder.client, why);
  }
  leases_.stop(by, why);
  note_standings();
  standings_.note_newer_epoch(leases_);
}

void StatusGrants::depart(ServerSession& session, bool in_order) {
  leases_.forget(session.id());
  session.standing->clear();  // before another client gets the status
  standings_.remove(session);
  std::erase_if(line_, [&](const Request& waiting) { return waiting.session.get() == &session; });
  tell_places();
  if (in_order) return release_all(session);
  if (!leases_.lose(session.id())) return;
  setup_.audit->status_lost(session.client(), session.parted_because);
  lose(session.id(), "its holder (" + session.caller().program + ", pid " +
                         std::to_string(session.caller().pid) + ") " + session.parted_because);
  serve_line();
}

void StatusGrants::on_tick(TimePoint now) {
  for (const auto& holder : leases_.expire(clock_.advance(now))) {
    const auto ttl = setup_.runtime->options().lease_ttl / std::chrono::milliseconds(1);
    setup_.audit->status_lost(holder.client, "silent for " + std::to_string(ttl) + " ms");
    lose(holder.session, "its holder has been silent for " + std::to_string(ttl) + " ms");
  }
  if (!line_.empty()) refuse_late(now);
}

void StatusGrants::note_feeder(const std::shared_ptr<ServerSession>& session) {
  standings_.add_feeder(session);
  note_standings();
}

void StatusGrants::lose(SessionId session, const std::string& why) {
  note_standings();
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
