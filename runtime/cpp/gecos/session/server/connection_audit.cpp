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
  if (!judgement.own) audit_->add(line_about("admitted", object, judgement));
  return "";
}

std::string ConnectionAudit::refused(std::string_view event, const std::string& object,
                                     const AccessControl::Judgement& judgement) {
  audit::Line entry = line_about(event, object, judgement);
  const MutexLock lock(mutex_);
  const std::uint64_t counter = ++refusals_;
  entry.request = {number(process_incarnation()), 0, counter};
  const std::string what = std::string(event) + '\0' + entry.user + '\0' + entry.host + '\0';
  const audit::Repeats::Key key{0, std::hash<std::string>()(what + object), 0};
  if (!repeats_.count(key, counter)) {
    repeats_.begin(key, entry);
    audit_->add(std::move(entry));
  }
  return judgement.text + named_request(SessionId{}, counter);
}

void ConnectionAudit::on_tick() {
  const MutexLock lock(mutex_);
  for (audit::Line& repeated : repeats_.due(audit::now())) audit_->add(std::move(repeated));
  audit_->flush();
}

}  // namespace gecos::session
