#include "gecos/session/server/status_grants.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <span>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/seconds.hpp"
#include "gecos/crypto/secret.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

/// Maximum time for which a request with the patience 0 waits until a handler has returned.
constexpr Duration longest_wait_for_handler = std::chrono::seconds(1);
/// The reason that is given when a status ends because its holder has released it.
constexpr std::string_view released = "released";

access::Status status_of(Status status) { return static_cast<access::Status>(status); }
Status status_of(access::Status status) { return static_cast<Status>(status); }

/// Returns the proof that is made from the password, and wipes the password.
access::Proof taken_from(std::optional<std::string>& password) {
  access::Proof proof = access::plain_proof(password.value_or(""));
  if (password) crypto::wipe(std::as_writable_bytes(std::span(*password)));
  return proof;
}

/// Returns the end of the text of a refusal, which says how long the request has waited and with
/// how many requests before it. Returns an empty text if the request did not wait.
std::string waited_in_vain(double patience, std::size_t before) {
  if (patience <= 0) return {};
  char text[96];
  std::snprintf(text, sizeof text, "; the request waited %g s, with %zu request%s before it",
                patience, before, before == 1 ? "" : "s");
  return text;
}

/// Records that the request `counter` of `session` for the status `wanted` is refused, and returns
/// the reply.
Failure recorded_refusal(const ObjectSetup& setup, const ServerSession& session,
                         std::uint64_t counter, Status wanted, const std::string& why,
                         std::vector<Holder> holders) {
  setup.audit->status_refused(session, counter, to_string(wanted), why);
  return status_refusal(setup.name + ": " + why + named_request(session.id(), counter),
                        std::move(holders));
}

/// Refuses the request `counter` of `session` for the status `wanted`, and records the refusal.
void refuse(const ObjectSetup& setup, ServerSession& session, std::uint64_t counter, Status wanted,
            const std::string& why, std::vector<Holder> holders) {
  session.reply(counter,
                recorded_refusal(setup, session, counter, wanted, why, std::move(holders)));
}

/// Returns a running command that was issued under a status that has ended, unless the interface
/// lets the command finish (`@on_loss("finish")`). Returns null when there is no such command or
/// when a client holds a status. While such a command runs, no client may be granted a status.
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

StatusGrants::StatusGrants(const ObjectSetup& setup, const NameClaim& claim, ObjectCalls& calls,
                           Prover& prover)
    : setup_(setup),
      claim_(claim),
      calls_(calls),
      leases_(process_incarnation(), setup.runtime->options().lease_ttl),
      clock_(setup.clock().now(), setup.runtime->options().heartbeat * 2),
      line_(setup.name, setup.clock()),
      roster_(setup, leases_, clock_),
      prover_(prover) {}

void StatusGrants::note_change(std::string_view why_ended) {
  standings_.note_change(leases_, clock_.now());
  roster_.note_change(why_ended);
}

// The functions below are about requests for a status.

void StatusGrants::request(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                           GecosObject_acquire_arguments asked) {
  if (status_of(asked.wanted) == access::Status::Sensor) {
    return session->reply(counter,
                          Failure{Detail::BadParameter,
                                  "every client has sensor status: acquire actor or master status",
                                  {},
                                  {}});
  }
  Duration patience = from_seconds(asked.patience);
  const bool handler_runs = outlives_its_status(leases_, calls_.queue()) != nullptr;
  if (handler_runs) patience = std::max(patience, longest_wait_for_handler);
  access::Proof password = taken_from(asked.password);
  StatusRequest request{session, counter, asked.wanted, asked.patience,
                        setup_.clock().now() + patience};
  if (!password.empty()) return prove(std::move(request), std::move(password));
  request.proof.emplace();
  if (!handler_runs && !line_.proving() && answer(request, line_.size())) return;
  if (line_.add(std::move(request))) line_.tell_places();
}

void StatusGrants::prove(StatusRequest request, access::Proof password) {
  const auto session = request.session;
  const std::uint64_t counter = request.counter;
  const media::Capabilities& line = session->connection().capabilities();
  if (!line.authenticated) {
    return session->reply(
        counter, Failure{Detail::Denied,
                         setup_.name + ": no password is accepted over " + std::string(line.name) +
                             ", because nothing proves who sends it",
                         {},
                         {}});
  }
  if (const auto refused = too_many_wrong(*session, status_of(request.wanted))) {
    return refuse(setup_, *session, counter, request.wanted, refused->text,
                  shown_to_clients(refused->holders, clock_.now()));
  }
  request.password = std::move(password);
  if (line_.add(std::move(request))) prove_next();
}

/// Begins to derive the next proof, unless one is being derived. A request that ends in the line is
/// never derived, so a client that sends and cancels many requests delays other clients by no more
/// than one derivation.
void StatusGrants::prove_next() {
  while (!proving_) {
    StatusRequest* const next = line_.first_to_prove();
    if (next == nullptr) return;
    const SessionId session = next->session->id();
    const std::uint64_t counter = next->counter;
    proving_ = prover_.prove(session, counter, std::exchange(next->password, {}));
    if (!proving_) settle(session, counter, std::nullopt);
  }
}

void StatusGrants::proved(SessionId session, std::uint64_t counter,
                          std::optional<access::Proof> proof) {
  proving_ = false;
  settle(session, counter, std::move(proof));
  prove_next();
}

void StatusGrants::settle(SessionId session, std::uint64_t counter,
                          std::optional<access::Proof> proof) {
  StatusRequest* const request = line_.find(session, counter);
  if (request == nullptr) return;
  if (!proof) {
    line_.end(session, counter,
              Failure{Detail::Rejected,
                      setup_.name + ": the server has no memory or no thread to check a password; "
                                    "try again later",
                      {},
                      {}});
  } else {
    request->proof = std::move(proof);
    if (outlives_its_status(leases_, calls_.queue()) != nullptr) {
      request->give_up =
          std::max(request->give_up, setup_.clock().now() + longest_wait_for_handler);
    }
  }
  serve_line();
}

/// Returns a refusal if the password of the client of `session` would have to be compared, but the
/// client's user has given too many wrong passwords. Otherwise returns nullopt.
std::optional<access::LeaseRefusal> StatusGrants::too_many_wrong(ServerSession& session,
                                                                 access::Status wanted) const {
  if (!leases_.compares_password(session.id())) return std::nullopt;
  const std::string why = passwords_.refusal(session, setup_.clock().now());
  if (why.empty()) return std::nullopt;
  return access::LeaseRefusal{access::LeaseRefusal::Reason::WrongPassword,
                              std::string(to_string(wanted)) + " status refused: " + why,
                              leases_.roster()};
}

/// Acquires the status for `request`. If the user who makes the request has given too many wrong
/// passwords, the password is not compared.
tl::expected<access::Grant, access::LeaseRefusal> StatusGrants::try_to_acquire(
    StatusRequest& request, std::size_t before, TimePoint now) {
  using Reason = access::LeaseRefusal::Reason;
  ServerSession& session = *request.session;
  const access::Status wanted = status_of(request.wanted);
  // A client that has released the status must not get it again before the clients that have waited
  // for it.
  if (before > 0 && leases_.releasing(session.id())) {
    return tl::unexpected(leases_.refusal_to_return(wanted, now));
  }
  const bool compares = !request.proof->empty() && leases_.compares_password(session.id());
  if (compares && !request.compared) {
    if (auto refused = too_many_wrong(session, wanted)) {
      request.patience = 0;
      request.give_up = setup_.clock().now();
      return tl::unexpected(*std::move(refused));
    }
  }
  auto granted = leases_.acquire(session.id(), session.client(), wanted, *request.proof, now);
  if (compares && !granted && granted.error().reason == Reason::WrongPassword &&
      !std::exchange(request.compared, true)) {
    passwords_.count_wrong(session, setup_.clock().now());
  }
  return granted;
}

/// Grants or refuses `request` and returns true, or returns false when the request must continue to
/// wait. `before`: the number of requests that wait before this request and could not be granted.
bool StatusGrants::answer(StatusRequest& request, std::size_t before) {
  const auto& session = request.session;
  const std::uint64_t counter = request.counter;
  if (claim_.standing() == NameClaim::Standing::Taken) {
    session->reply(counter, status_refusal(setup_.name + ": " + claim_.text(), {}));
    return true;
  }
  const TimePoint now = clock_.now();
  const bool held_before = leases_.status_of(session->id()) != access::Status::Sensor;
  auto granted = try_to_acquire(request, before, now);
  if (!granted && setup_.clock().now() < request.give_up) return false;
  if (log_enabled(LogLevel::Info)) {
    log_info("server", setup_.name + ": " + who(session->caller()) +
                           (granted ? " has " : " is refused ") +
                           std::string(to_string(request.wanted)) + " status" +
                           (granted ? "" : ": " + granted.error().text));
  }
  if (granted) {
    setup_.audit->status("status_granted", *session, counter, to_string(request.wanted));
    if (!held_before) {
      session->held_from = number(granted->epoch);
      standings_.add_holder(session);
    }
    note_change();
    const Grant given{status_of(granted->status), number(granted->epoch)};
    session->reply(counter, layout::to_bytes(GecosObject_acquire_result{given}));
  } else {
    refuse(setup_, *session, counter, request.wanted,
           granted.error().text + waited_in_vain(request.patience, before),
           shown_to_clients(granted.error().holders, now));
  }
  return true;
}

void StatusGrants::serve_line() {
  if (line_.empty() || outlives_its_status(leases_, calls_.queue()) != nullptr) return;
  bool proving = false;  // later requests wait behind one whose proof is being derived
  line_.remove_if([&](StatusRequest& request, std::size_t before) {
    proving = proving || !request.proof;
    return !proving && answer(request, before);
  });
  line_.tell_places();
}

void StatusGrants::refuse_late(TimePoint now) {
  const ServerCall* const runs = outlives_its_status(leases_, calls_.queue());
  if (runs == nullptr) return serve_line();
  line_.remove_if([&](const StatusRequest& waiting, std::size_t /*before*/) {
    if (now < waiting.give_up) return false;
    access::Holder last;
    last.client = runs->session->client();
    last.since = last.expires = clock_.now();
    last.releasing = true;
    refuse(setup_, *waiting.session, waiting.counter, waiting.wanted,
           std::string(access::to_string(status_of(waiting.wanted))) +
               " status refused: the handler of '" + std::string(runs->operation().name) +
               "' still runs (issued by " + who(runs->caller()) +
               "), although the status under which this command was issued has ended; the handler "
               "was told to end: try again",
           shown_to_clients(std::vector{last}, clock_.now()));
    return true;
  });
  line_.tell_places();
}

bool StatusGrants::deny(std::uint64_t id, const std::string& why) {
  const StatusRequest* const denied = line_.find(id);
  if (denied == nullptr) return false;
  const auto session = denied->session;
  const std::uint64_t counter = denied->counter;
  return line_.end(
      session->id(), counter,
      recorded_refusal(setup_, *session, counter, denied->wanted, why, roster_.holders()));
}

void StatusGrants::close() {
  const Failure ends{Detail::Rejected, "the server is about to end", {}, {}};
  line_.end_all(ends);
  line_.end_questions(ends);
  roster_.close();
}

// The functions below are about the end of a status.

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
  note_change(released);
  serve_line();
  if (log_enabled(LogLevel::Info)) {
    log_info("server", setup_.name + ": " + who(session.caller()) + " releases its status" +
                           (asked.now ? ", and stops the commands issued under this status" : ""));
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
  note_change(released);
  serve_line();
}

std::optional<Failure> StatusGrants::take_over(ServerSession& session) {
  const TimePoint now = clock_.now();
  if (const auto taken = leases_.take_over(session.id(), now); !taken) {
    return status_refusal(setup_.name + ": " + taken.error().text,
                          shown_to_clients(taken.error().holders, now));
  }
  log_info("server",
           setup_.name + ": " + who(session.caller()) + " takes sole command of the status");
  setup_.audit->status("taken_over", session);
  // Must be called before a reply is sent or a command is ended below, because the replies tell the
  // clients the new epoch.
  standings_.note_newer_epoch(leases_);
  note_change();
  calls_.end_commands(
      [&](const ServerCall& call) {
        return call.client != session.id() && commands_the_object(call.operation());
      },
      Failure{Detail::Preempted, who(session.caller()) + " has taken over", {}, {}});
  return std::nullopt;
}

void StatusGrants::give_back(ServerSession& session) {
  if (!leases_.give_back(session.id())) return;
  note_change();
  log_info("server",
           setup_.name + ": " + who(session.caller()) + " gives sole command of the status back");
  setup_.audit->status("given_back", session);
}

void StatusGrants::commands_ended(SessionId session) {
  if (leases_.releasing(session)) {
    leases_.drained(session);
    note_change(released);
  }
  serve_line();
}

void StatusGrants::stop(SessionId by, const std::string& why) {
  line_.end_all(
      Failure{Detail::Stopped, "the request for the status ended while it waited: " + why, {}, {}});
  for (const auto& holder : leases_.roster()) {
    if (holder.session != by) setup_.audit->status_lost(holder.client, why);
  }
  leases_.stop(by, why);
  standings_.note_newer_epoch(leases_);
  note_change(why);
}

void StatusGrants::break_all(const std::string& why) {
  std::vector<SessionId> lost;
  for (const access::Holder& holder :
       leases_.stop(SessionId{}, why, access::Denial::Reason::LeaseEnded)) {
    lost.push_back(holder.session);
    setup_.audit->status_lost(holder.client, why);
  }
  lose(lost, why);
  standings_.note_newer_epoch(leases_);
  serve_line();
}

void StatusGrants::depart(ServerSession& session, bool in_order) {
  leases_.forget(session.id());
  session.standing->clear();  // before another client gets the status
  standings_.remove(session);
  line_.forget(session.id());
  roster_.questions().forget(session.id());
  if (in_order) return release_all(session);
  if (!leases_.lose(session.id())) return;
  setup_.audit->status_lost(session.client(), session.parted_because);
  lose({session.id()}, "its holder (" + session.caller().program + ", pid " +
                           std::to_string(session.caller().pid) + ") " + session.parted_because);
  serve_line();
}

void StatusGrants::on_tick(TimePoint now) {
  for (const auto& holder : leases_.expire(clock_.advance(now))) {
    const auto ttl = setup_.runtime->options().lease_ttl / std::chrono::milliseconds(1);
    setup_.audit->status_lost(holder.client, "silent for " + std::to_string(ttl) + " ms");
    lose({holder.session}, "its holder has been silent for " + std::to_string(ttl) + " ms");
  }
  if (!line_.empty()) refuse_late(now);
  line_.on_tick();
  roster_.on_tick();
}

void StatusGrants::note_feeder(const std::shared_ptr<ServerSession>& session) {
  standings_.add_feeder(session);
  standings_.note_change(leases_, clock_.now());
}

void StatusGrants::lose(const std::vector<SessionId>& sessions, const std::string& why) {
  note_change(why);
  log_info("server", setup_.name + ": a status ended: " + why);
  const Failure failure{
      Detail::LeaseLost, "the status under which the command was issued ended: " + why, {}, {}};
  calls_.end_commands(
      [&](const ServerCall& call) {
        return std::ranges::find(sessions, call.client) != sessions.end() &&
               call.operation().status != access::Status::Sensor &&
               (call.state.queued() || call.operation().on_loss != OnLoss::Finish);
      },
      failure);
}

}  // namespace gecos::session
