#include "gecos/session/server/server_call.hpp"

#include "gecos/binding.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

ServerCall::ServerCall(std::shared_ptr<ServerSession> its_session,
                       const OperationDescription& its_operation, std::uint64_t its_counter,
                       Epoch its_epoch, ByteView arguments)
    : QueueEntry(its_session->id(), its_operation, arguments.size()),
      session(std::move(its_session)),
      counter(its_counter),
      epoch(its_epoch),
      arguments_(arguments) {}

ObjectHost& ServerCall::object() const { return *session->object(); }

std::string ServerCall::title() const {
  return "'" + std::string(operation().name) + "' of " + object().name();
}

std::string refusal_to_register(const CallCore& call, const std::string& name) {
  const auto* const served = dynamic_cast<const ServerCall*>(&call);
  if (served == nullptr) return {};  // a call that a test made itself
  ServerSession& client = *served->session;
  return client.object()->setup().rights.refusal_to_register(name, client.connection().peer());
}

std::optional<ProvedUser> other_user_of(const CallCore& call) {
  const auto* const served = dynamic_cast<const ServerCall*>(&call);
  if (served == nullptr) return std::nullopt;  // a call that a test made itself
  const media::Peer& peer = served->session->connection().peer();
  auto who = served->session->object()->setup().rights.other_user(peer);
  if (!who) return std::nullopt;
  return ProvedUser{*std::move(who), peer.key, peer.pid};
}

std::optional<access::UserAtHost> visitor_of(const CallCore& call) {
  const auto* const served = dynamic_cast<const ServerCall*>(&call);
  if (served == nullptr) return std::nullopt;  // a call that a test made itself
  const access::UserAtHost* const who = served->session->visit.visitor();
  return who == nullptr ? std::nullopt : std::optional(*who);
}

const Caller& ServerCall::caller() const { return session->caller(); }

bool ServerCall::wait_interrupted_until(TimePoint until) {
  return object().runner().wait_interrupted(*this, until);
}

bool ServerCall::begin() { return object().runner().begin(*this); }

std::optional<TimePoint> ServerCall::marked_at() const {
  const TimePoint at = marked_at_.load(std::memory_order_relaxed);
  return at == TimePoint::max() ? std::nullopt : std::optional(at);
}

void ServerCall::waits(const CommandCore& command) {
  object().waits().waits(*this, command.id(), command.about());
}

void ServerCall::goes_on() { object().waits().goes_on(*this); }

void ServerCall::progress(double its_fraction, ByteView its_feedback) {
  object().runner().progressed(*this, its_fraction, its_feedback);
}

void ServerCall::let_next() { object().runner().let_next(*this); }

void ServerCall::finish(ByteView result) { object().runner().answered(*this, result); }

void ServerCall::fail(Failure failure) { object().runner().answered(*this, std::move(failure)); }

}  // namespace gecos::session
