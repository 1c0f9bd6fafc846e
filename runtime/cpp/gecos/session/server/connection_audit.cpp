#include "gecos/session/server/connection_audit.hpp"

#include <utility>

#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {

audit::Line ConnectionAudit::line_about(std::string_view event, const std::string& object,
                                        const AccessControl::Judgement& judgement) const {
  return {.event = event,
          .time = now_(),
          .object = object,
          .why = judgement.text,
          .user = judgement.who.user,
          .host = judgement.who.host};
}

std::string ConnectionAudit::judged(const std::string& object,
                                    const AccessControl::Judgement& judgement) {
  if (!judgement.admitted) return refused("refused", object, judgement);
  if (judgement.own) return "";
  audit::Line entry = line_about("admitted", object, judgement);
  if (judgement.visitor) {
    const MutexLock lock(mutex_);
    lines_.add(entry, entry);
  } else {
    audit_->add(std::move(entry));
  }
  return "";
}

std::string ConnectionAudit::refused(std::string_view event, const std::string& object,
                                     const AccessControl::Judgement& judgement) {
  audit::Line entry = line_about(event, object, judgement);
  const MutexLock lock(mutex_);
  const std::uint64_t counter = ++refusals_;
  entry.request = {number(process_incarnation()), 0, counter};
  const SessionId kind{lines_.add(entry, entry)};
  return judgement.text + named_request(kind, counter);
}

void ConnectionAudit::on_tick() {
  const MutexLock lock(mutex_);
  lines_.on_tick(now_());
  audit_->flush();
}

void ConnectionAudit::end() {
  const MutexLock lock(mutex_);
  lines_.end(now_());
}

}  // namespace gecos::session
