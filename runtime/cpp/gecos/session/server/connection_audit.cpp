#include "gecos/session/server/connection_audit.hpp"

#include <functional>
#include <utility>

#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {

std::string ConnectionAudit::judged(const std::string& object,
                                    const AccessControl::Judgement& judgement) {
  audit::Line entry{.event = judgement.admitted ? "admitted" : "refused",
                    .time = audit::now(),
                    .object = object,
                    .why = judgement.text,
                    .user = judgement.who.user,
                    .host = judgement.who.host};
  if (judgement.admitted) {
    if (!judgement.own) audit_->add(std::move(entry));
    return "";
  }
  const MutexLock lock(mutex_);
  const std::uint64_t counter = ++refusals_;
  entry.request = {number(process_incarnation()), 0, counter};
  const audit::Repeats::Key key{
      0, std::hash<std::string>()(entry.user + '\0' + entry.host + '\0' + object), 0};
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
