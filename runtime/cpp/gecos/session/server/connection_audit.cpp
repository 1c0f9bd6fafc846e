#include "gecos/session/server/connection_audit.hpp"

#include <functional>
#include <utility>

#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {
namespace {

audit::Line line_about(std::string_view event, const std::string& object,
                       const AccessControl::Judgement& judgement) {
  return {.event = event,
          .time = audit::now(),
          .object = object,
          .why = judgement.text,
          .user = judgement.who.user,
          .host = judgement.who.host};
}

}  // namespace

std::string ConnectionAudit::judged(const std::string& object,
                                    const AccessControl::Judgement& judgement) {
  if (!judgement.admitted) return refused("refused", object, judgement);
  if (judgement.own) return "";
  audit::Line entry = line_about("admitted", object, judgement);
  if (judgement.visitor) {
    const MutexLock lock(mutex_);
    add_or_count(std::move(entry));
  } else {
    audit_->add(std::move(entry));
  }
  return "";
}

void ConnectionAudit::add_or_count(audit::Line entry) {
  const std::string what =
      std::string(entry.event) + '\0' + entry.user + '\0' + entry.host + '\0' + entry.object;
  const audit::Repeats::Key key{0, std::hash<std::string>()(what), 0};
  if (repeats_.count(key, entry.request.counter)) return;
  repeats_.begin(key, entry);
  audit_->add(std::move(entry));
}

std::string ConnectionAudit::refused(std::string_view event, const std::string& object,
                                     const AccessControl::Judgement& judgement) {
  audit::Line entry = line_about(event, object, judgement);
  const MutexLock lock(mutex_);
  const std::uint64_t counter = ++refusals_;
  entry.request = {number(process_incarnation()), 0, counter};
  add_or_count(std::move(entry));
  return judgement.text + named_request(SessionId{}, counter);
}

void ConnectionAudit::on_tick() {
  const MutexLock lock(mutex_);
  for (audit::Line& repeated : repeats_.due(audit::now())) audit_->add(std::move(repeated));
  audit_->flush();
}

}  // namespace gecos::session
