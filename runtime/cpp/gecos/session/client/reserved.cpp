#include "gecos/reserved.hpp"

#include <ostream>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/builtin_codec.hpp"
#include "gecos/session/protocol/function_code.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos {
namespace {

using session::BuiltIn;

std::shared_ptr<session::CommandCore> call_bare(const Object& object, BuiltIn which) {
  return session_of(object)->call(session::builtin_operation(which), 0, [](wire::Encoder&) {}, {});
}

tl::expected<Lease, LeaseRefusal> acquire(const Object& object, Status wanted,
                                          const std::string& password) {
  const auto& session = session_of(object);
  const std::size_t size = 4 + 1 + (password.empty() ? 0 : wire::string_size(password));
  const auto command = session->call(session::builtin_operation(BuiltIn::Acquire), size,
                                     [&](wire::Encoder& to) {
                                       to.put(static_cast<std::int32_t>(wanted));
                                       to.put(!password.empty());
                                       if (!password.empty()) to.put_string(password);
                                     },
                                     {});
  command->wait_until(TimePoint::max());
  if (command->progress().detail != Detail::Done) {
    LeaseRefusal refusal{command->failure(), {}};
    if (auto refused = refusal.failure.as<StatusRefused>()) {
      refusal.holders = std::move(refused->holders);
    }
    return tl::unexpected(std::move(refusal));
  }
  Grant grant;
  wire::Decoder from(command->result());
  if (!wire::get_block(from, grant, "grant")) {
    return tl::unexpected(LeaseRefusal{
        {Detail::Fault, "the reply does not decode: " + from.error().message(), {}, {}}, {}});
  }
  return Lease(session, grant);
}

}  // namespace

Lease::Lease(std::shared_ptr<session::ClientSession> session, Grant grant)
    : session_(std::move(session)),
      grant_(grant),
      held_(session_->lease_acquired(grant.epoch)),
      issued_(session_->issued()),
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
                             " was given back at once, before anything was issued under it; keep "
                             "the lease: `const auto lease = gecos::actor(*robot);`");
  }
  release();
}

bool Lease::fresh() const {
  constexpr Duration at_once = std::chrono::milliseconds(100);
  return session_ != nullptr && session_->issued() == issued_ &&
         session::system_clock().now() - since_ < at_once;
}

void Lease::release() { give_back(false); }

void Lease::release_now() { give_back(true); }

void Lease::give_back(bool now) {
  constexpr Duration patience = std::chrono::seconds(1);
  const auto session = std::exchange(session_, nullptr);
  if (session == nullptr) return;
  session->lease_released(held_);
  const auto released = session->call(session::builtin_operation(BuiltIn::Release), 8 + 1,
                                      [&](wire::Encoder& to) {
                                        to.put(grant_.epoch);
                                        to.put(now);
                                      },
                                      {});
  released->wait_until(deadline_after(patience));
}

std::ostream& operator<<(std::ostream& out, const LeaseRefusal& refusal) {
  return out << refusal.failure;
}

Checked<Lease, LeaseRefusal> actor(const Object& object, std::string password) {
  return acquire(object, Status::ACTOR, password);
}

Checked<Lease, LeaseRefusal> master(const Object& object, std::string password) {
  return acquire(object, Status::MASTER, password);
}

Command<void> stop(const Object& object) { return Command<void>(call_bare(object, BuiltIn::Stop)); }

Command<void> ping(const Object& object) { return Command<void>(call_bare(object, BuiltIn::Ping)); }

Command<Description> describe(const Object& object) {
  return Command<Description>(call_bare(object, BuiltIn::Describe),
                              [](wire::Decoder& from, Description& value) {
                                return wire::get_block(from, value, "description");
                              });
}

Command<std::vector<Holder>> holders(const Object& object) {
  return Command<std::vector<Holder>>(call_bare(object, BuiltIn::Holders),
                                      [](wire::Decoder& from, std::vector<Holder>& value) {
                                        return session::get_blocks(from, value);
                                      });
}

std::ostream& operator<<(std::ostream& out, const Outcome& outcome) {
  return out << outcome.detail << (outcome.text.empty() ? "" : ": ") << outcome.text;
}

Command<Outcome> outcome(const Object& object, const CommandId& id) {
  const auto decode = [](wire::Decoder& from, Outcome& value) {
    OutcomeRecord record;
    if (!wire::get_block(from, record, "outcome")) return false;
    const auto detail = detail_from(record.detail);
    if (!detail) return from.fail(wire::DecodeProblem::UnknownEnumerator, "detail");
    value = {*detail, std::move(record.text)};
    return true;
  };
  if (id == CommandId{}) {
    return {session::ended({Detail::BadParameter,
                            "a command that was never sent has no outcome"
                            " but its own",
                            {},
                            {}}),
            decode};
  }
  return {session_of(object)->call(session::builtin_operation(BuiltIn::Outcome), 3 * 8,
                                   [&](wire::Encoder& to) {
                                     to.put(id.incarnation);
                                     to.put(id.session);
                                     to.put(id.counter);
                                   },
                                   {}),
          decode};
}

}  // namespace gecos
