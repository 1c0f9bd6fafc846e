#include "gecos/session/server/object_audit.hpp"

#include <utility>

#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {
namespace {

/// Returns whether the audit records every call of `operation`, because the operation moves or
/// stops something.
bool recorded(const OperationDescription& operation) {
  return operation.status != access::Status::Sensor || operation.safety;
}

/// Returns whether the outcome of `call` comes from its handler. The text of such an outcome may
/// contain arguments of the call, so the audit must not record the text.
bool answered_by_handler(const ServerCall& call) {
  return call.state.begun_at() && call.state.phase() >= CallState::Phase::Answered;
}

/// Returns `entry` without the members that differ between the sessions of the visitor `who`.
audit::Line without_session(audit::Line entry, const access::UserAtHost& who) {
  entry.user = who.user;
  entry.host = who.host;
  entry.program.clear();
  entry.pid = 0;
  entry.medium.clear();
  return entry;
}

}  // namespace

std::string named_request(SessionId session, std::uint64_t counter) {
  if (counter == 0) return "";
  const audit::RequestId id{number(process_incarnation()), number(session), counter};
  return " (request " + audit::to_string(id) + ")";
}

audit::Line ObjectAudit::line(std::string_view event, const Caller& caller,
                              std::uint64_t counter) const {
  return {.event = event,
          .time = audit::now(),
          .object = object_,
          .request = {number(process_incarnation()), caller.session, counter},
          .user = caller.user,
          .host = caller.host,
          .program = caller.program,
          .pid = caller.pid};
}

void ObjectAudit::connected(ServerSession& session) {
  if (!audit_) return;
  audit::Line entry = line("connected", session.caller());
  entry.medium = session.connection().capabilities().name;
  add_of_session(session, std::move(entry));
}

void ObjectAudit::disconnected(const ServerSession& session, std::string_view because) {
  if (!audit_) return;
  audit::Line entry = line("disconnected", session.caller());
  entry.why = because;
  add_of_session(session, std::move(entry));
}

void ObjectAudit::add_of_session(const ServerSession& session, audit::Line entry) {
  const access::UserAtHost* const visitor = session.visit.visitor();
  if (visitor == nullptr) return audit_->add(std::move(entry));
  audit::Line further = without_session(entry, *visitor);
  visitors_.add(std::move(entry), std::move(further));
}

void ObjectAudit::status(std::string_view event, const ServerSession& session,
                         std::uint64_t counter, std::string_view status) {
  if (!audit_) return;
  audit::Line entry = line(event, session.caller(), counter);
  entry.status = status;
  audit_->add(std::move(entry));
}

void ObjectAudit::status_refused(const ServerSession& session, std::uint64_t counter,
                                 std::string_view status, const std::string& why) {
  if (!audit_) return;
  const audit::Repeats::Key key{number(session.id()), number(GecosObjectInterface::acquire.code),
                                static_cast<std::uint8_t>(Detail::Denied)};
  if (repeats_.count(key, counter)) return;
  audit::Line entry = line("status_refused", session.caller(), counter);
  entry.status = status;
  entry.why = why;
  begin(key, std::move(entry));
}

void ObjectAudit::stopped(const ServerSession& by, std::uint64_t counter) {
  if (!audit_) return;
  const audit::Repeats::Key key{number(by.id()), number(GecosObjectInterface::stop.code), 0};
  if (repeats_.count(key, counter)) return;
  begin(key, line("stopped", by.caller(), counter));
}

void ObjectAudit::status_lost(const access::Client& holder, const std::string& why) {
  if (!audit_) return;
  audit::Line entry = line("status_lost", {holder.user, holder.host, holder.program, holder.pid});
  entry.why = why;
  audit_->add(std::move(entry));
}

void ObjectAudit::begin(const audit::Repeats::Key& key, audit::Line entry) {
  repeats_.begin(key, entry);
  audit_->add(std::move(entry));
}

void ObjectAudit::command(const ServerSession& session, std::uint64_t counter, FunctionCode code,
                          std::string_view operation, Detail detail, std::string_view why) {
  const audit::Repeats::Key key{number(session.id()), number(code),
                                static_cast<std::uint8_t>(detail)};
  if (repeats_.count(key, counter)) return;
  audit::Line entry = line("command", session.caller(), counter);
  entry.operation = operation;
  entry.outcome = to_string(detail);
  entry.why = why;
  begin(key, std::move(entry));
}

void ObjectAudit::refused(const ServerSession& session, std::uint64_t counter, FunctionCode code,
                          std::string_view operation, const Failure& failure) {
  if (audit_) command(session, counter, code, operation, failure.detail, failure.text);
}

std::string ObjectAudit::visitor_refused(const ServerSession& session, std::uint64_t counter,
                                         std::string_view operation, const Failure& failure,
                                         const std::string& because) {
  if (!audit_) return named_request(session.id(), counter);
  audit::Line entry = line("command", session.caller(), ++visitor_refusals_);
  entry.outcome = to_string(failure.detail);
  audit::Line further = without_session(entry, *session.visit.visitor());
  entry.operation = operation;
  entry.why = failure.text;
  further.operation = "several operations";
  further.why = because;
  const SessionId kind{visitors_.add(std::move(entry), std::move(further))};
  return named_request(kind, visitor_refusals_);
}

void ObjectAudit::begins(const ServerCall& call) {
  const OperationDescription& operation = call.operation();
  if (!audit_ || !recorded(operation) || !operation.cancelable) return;
  audit::Line entry = line("command_begins", call.caller(), call.counter);
  entry.operation = operation.name;
  audit_->add(std::move(entry));
}

void ObjectAudit::ended(const ServerCall& call, Detail detail, const std::string& text) {
  const OperationDescription& operation = call.operation();
  if (!audit_ || !recorded(operation)) return;
  command(*call.session, call.counter, operation.code, operation.name, detail,
          answered_by_handler(call) ? std::string_view() : text);
}

void ObjectAudit::on_tick() {
  if (!audit_) return;
  for (audit::Line& repeated : repeats_.due(audit::now())) audit_->add(std::move(repeated));
  visitors_.on_tick(audit::now());
  audit_->flush();
}

void ObjectAudit::end() {
  if (!audit_) return;
  for (audit::Line& repeated : repeats_.all(audit::now())) audit_->add(std::move(repeated));
  visitors_.end(audit::now());
}

}  // namespace gecos::session
