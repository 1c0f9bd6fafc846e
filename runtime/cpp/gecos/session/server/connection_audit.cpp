#include "gecos/session/server/connection_audit.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "gecos/session/server/object_audit.hpp"

namespace gecos::session {
namespace {

/// Digits of the reason do not count: a reason may say since when something has lasted.
audit::Repeats::Key key_of(const audit::Line& line) {
  std::string what =
      std::string(line.event) + '\0' + line.user + '\0' + line.host + '\0' + line.object + '\0';
  std::ranges::copy_if(line.why, std::back_inserter(what),
                       [](char c) { return c < '0' || c > '9'; });
  return {0, std::hash<std::string>()(what), 0};
}

}  // namespace

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
    const audit::Repeats::Key key = key_of(entry);
    const MutexLock lock(mutex_);
    add_or_count(key, std::move(entry));
  } else {
    audit_->add(std::move(entry));
  }
  return "";
}

void ConnectionAudit::add_or_count(const audit::Repeats::Key& key, audit::Line entry) {
  if (repeats_.count(key, entry.request.counter)) return;
  repeats_.begin(key, entry, audit::Repeats::Window::Growing);
  audit_->add(std::move(entry));
}

std::string ConnectionAudit::refused(std::string_view event, const std::string& object,
                                     const AccessControl::Judgement& judgement) {
  audit::Line entry = line_about(event, object, judgement);
  const audit::Repeats::Key key = key_of(entry);
  const MutexLock lock(mutex_);
  const std::uint64_t counter = ++refusals_;
  // A line that counts refusals names the first and the last one: the numbers of other users in
  // between have another middle part.
  entry.request = {number(process_incarnation()), key.code, counter};
  add_or_count(key, std::move(entry));
  return judgement.text + named_request(SessionId{key.code}, counter);
}

void ConnectionAudit::on_tick() {
  const MutexLock lock(mutex_);
  for (audit::Line& repeated : repeats_.due(now_())) audit_->add(std::move(repeated));
  audit_->flush();
}

void ConnectionAudit::end() {
  const MutexLock lock(mutex_);
  for (audit::Line& repeated : repeats_.all()) audit_->add(std::move(repeated));
}

}  // namespace gecos::session
