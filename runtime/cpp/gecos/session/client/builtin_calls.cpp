#include <algorithm>
#include <chrono>
#include <ostream>

#include "gecos/base/log.hpp"
#include "gecos/base/seconds.hpp"
#include "gecos/binding.hpp"
#include "gecos/builtin_operations.hpp"
#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/own_call.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos {
namespace {

using session::own_call;
using session::read_result;

/// Waits for the reply to the request `asked`. Until then, calls `on_position` with the number of
/// requests that wait before this request.
void await_reply(session::CommandCore& asked,
                 const std::function<void(std::uint32_t)>& on_position) {
  if (!on_position) {
    asked.wait_until(TimePoint::max());
    return;
  }
  constexpr Duration between_looks = std::chrono::milliseconds(50);  // progress wakes no thread
  std::optional<std::uint32_t> reported;
  while (!asked.wait_until(deadline_after(between_looks))) {
    const Progress progress = asked.progress();
    if (progress.detail != Detail::Queued || reported == progress.position) continue;
    reported = progress.position;
    on_position(progress.position);
  }
}

tl::expected<Lease, LeaseRefusal> acquire(const Object& object, Status wanted,
                                          const LeaseOptions& options) {
  const auto& session = session_of(object);
  const auto asked = session::ask_for_status(*session, wanted, options.password, options.timeout);
  try {
    await_reply(*asked, options.on_position);
  } catch (...) {
    session::decline_status(session, asked);
    throw;
  }
  return session::lease_from(session, *asked);
}

/// Converts `timeout` to the seconds for which a server may delay its reply, while there is no
/// news.
double patience_for(Duration timeout) { return to_seconds(std::max(timeout, Duration::zero())); }

/// Returns the number of calls of the session, plus the number of calls that this process refused
/// before they were sent.
std::uint64_t issued_calls(session::ClientSession& session) {
  return session.issued() + session::Refused::count();
}

}  // namespace

Lease::Lease(std::shared_ptr<session::ClientSession> session, Grant grant)
    : session_(std::move(session)),
      grant_(grant),
      held_(session_->lease_acquired(grant.epoch)),
      issued_(issued_calls(*session_)),
      since_(session::system_clock().now()) {}

Lease& Lease::operator=(Lease&& other) noexcept {
  if (this != &other) {
    release();
    session_ = std::move(other.session_);
    grant_ = other.grant_;
    held_ = other.held_;
    issued_ = other.issued_;
    since_ = other.since_;
  }
  return *this;
}

Lease::~Lease() {
  if (session_ != nullptr && fresh()) {
    log_warning("lease", std::string(to_string(grant_.status)) + " status of " +
                             session_->object_name() +
                             " was released at once, before any command was issued under it; keep "
                             "the lease as long as you need the status");
  }
  release();
}

bool Lease::fresh() const {
  constexpr Duration at_once = std::chrono::milliseconds(100);
  return session_ != nullptr && issued_calls(*session_) == issued_ &&
         session::system_clock().now() - since_ < at_once;
}

bool Lease::lost() const { return session_ != nullptr && session_->lease_lost(held_); }

void Lease::release() { send_release(false); }

void Lease::release_now() { send_release(true); }

void Lease::send_release(bool now) {
  constexpr Duration patience = std::chrono::seconds(1);
  const auto session = std::exchange(session_, nullptr);
  if (session == nullptr) return;
  session->lease_released(held_);
  const auto released = own_call(*session, GecosObjectInterface::release,
                                 GecosObject_release_arguments{grant_.epoch, now});
  released->wait_until(deadline_after(patience));
}

std::ostream& operator<<(std::ostream& out, const LeaseRefusal& refusal) {
  // If the server refused the request, prints only the text of the refusal. The detail FAULT, which
  // every declared exception has, would make the reader look for a broken server.
  if (refusal.failure.as<StatusRefused>()) return out << refusal.failure.text;
  return out << refusal.failure;
}

Checked<Lease, LeaseRefusal> actor(const Object& object, std::string password) {
  return acquire(object, Status::ACTOR, {.password = std::move(password)});
}

Checked<Lease, LeaseRefusal> actor(const Object& object, const LeaseOptions& options) {
  return acquire(object, Status::ACTOR, options);
}

Checked<Lease, LeaseRefusal> master(const Object& object, std::string password) {
  return acquire(object, Status::MASTER, {.password = std::move(password)});
}

Checked<Lease, LeaseRefusal> master(const Object& object, const LeaseOptions& options) {
  return acquire(object, Status::MASTER, options);
}

Command<void> stop(const Object& object) {
  return Command<void>(own_call(*session_of(object), GecosObjectInterface::stop));
}

Command<void> take_over(const Object& object) {
  return Command<void>(own_call(*session_of(object), GecosObjectInterface::take_over));
}

Command<void> give_back(const Object& object) {
  return Command<void>(own_call(*session_of(object), GecosObjectInterface::give_back));
}

Command<std::vector<WaitingRequest>> requests(const Object& object, std::uint64_t after,
                                              Duration timeout) {
  return {own_call(*session_of(object), GecosObjectInterface::requests,
                   GecosObject_requests_arguments{after, patience_for(timeout)}),
          read_result<GecosObject_requests_result, std::vector<WaitingRequest>>};
}

Command<bool> deny(const Object& object, std::uint64_t request, const std::string& why) {
  return {own_call(*session_of(object), GecosObjectInterface::deny,
                   GecosObject_deny_arguments{request, why}),
          read_result<GecosObject_deny_result, bool>};
}

Command<void> break_status(const Object& object, const std::string& why) {
  return Command<void>(own_call(*session_of(object), GecosObjectInterface::break_status,
                                GecosObject_break_status_arguments{why}));
}

Command<void> ping(const Object& object) {
  return Command<void>(own_call(*session_of(object), GecosObjectInterface::ping));
}

Command<Description> describe(const Object& object) {
  return {own_call(*session_of(object), GecosObjectInterface::describe),
          read_result<GecosObject_describe_result, Description>};
}

Command<std::vector<Holder>> holders(const Object& object) {
  return {own_call(*session_of(object), GecosObjectInterface::holders),
          read_result<GecosObject_holders_result, std::vector<Holder>>};
}

Command<Roster> roster(const Object& object, std::uint64_t after, Duration timeout) {
  return {own_call(*session_of(object), GecosObjectInterface::roster,
                   GecosObject_roster_arguments{after, patience_for(timeout)}),
          read_result<GecosObject_roster_result, Roster>};
}

Command<ObjectStats> stats(const Object& object) {
  return {own_call(*session_of(object), GecosObjectInterface::stats),
          read_result<GecosObject_stats_result, ObjectStats>};
}

Command<std::vector<std::string>> model(const Object& object) {
  return {own_call(*session_of(object), GecosObjectInterface::model),
          read_result<GecosObject_model_result, std::vector<std::string>>};
}

std::ostream& operator<<(std::ostream& out, const Outcome& outcome) {
  return out << outcome.detail << (outcome.text.empty() ? "" : ": ") << outcome.text;
}

Command<Outcome> outcome(const Object& object, const CommandId& id) {
  const auto decode = [](wire::Decoder& from, Outcome& value) {
    OutcomeRecord record;
    if (!read_result<GecosObject_outcome_result>(from, record)) return false;
    const auto detail = detail_from(record.detail);
    if (!detail) return from.fail(wire::DecodeProblem::UnknownEnumerator, "detail");
    value = {*detail, std::move(record.text)};
    return true;
  };
  if (id == CommandId{}) {
    return {session::ended({Detail::BadParameter,
                            "the command was never sent, so the server has"
                            " no outcome of the command",
                            {},
                            {}}),
            decode};
  }
  return {own_call(*session_of(object), GecosObjectInterface::outcome,
                   GecosObject_outcome_arguments{id.incarnation, id.session, id.counter}),
          decode};
}

}  // namespace gecos
