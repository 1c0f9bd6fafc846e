#include "gecos/session/server/presence_guard.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/host_state.hpp"

namespace gecos::session {

template <class Change>
void PresenceGuard::change(Change change) {
  std::string text;
  {
    const MutexLock lock(object_.mutex);
    const TimePoint now = object_.setup.clock().since_boot();
    if (!change(object_.presence, now)) return;
    text = "presence was lost: " + object_.presence.text(now);
    object_.calls.end_commands(
        [](const ServerCall& call) { return needs_presence(call.operation()); },
        Failure{Detail::PresenceLost, text + "; nothing resumes by itself", {}, {}});
    if (object_.setup.options.on_stop) object_.user_callbacks.post(object_.setup.options.on_stop);
  }
  log_warning("session", object_.setup.name + " is stopped: " + text);
}

std::string PresenceGuard::zone() {
  const MutexLock lock(object_.mutex);
  return object_.presence.zone();
}

void PresenceGuard::enter(const std::string& zone) {
  change(
      [&](access::ObjectPresence& presence, TimePoint now) { return presence.enter(zone, now); });
}

void PresenceGuard::take(const std::string& zone, access::ObjectPresence::Report report,
                         TimePoint made) {
  change([&](access::ObjectPresence& presence, TimePoint now) {
    return presence.zone() == zone && presence.take(std::move(report), made, now);
  });
}

void PresenceGuard::forget(const std::string& zone, const std::string& why) {
  change([&](access::ObjectPresence& presence, TimePoint now) {
    return presence.zone() == zone && presence.forget(why, now);
  });
}

void PresenceGuard::forget(const std::string& why) {
  change(
      [&](access::ObjectPresence& presence, TimePoint now) { return presence.forget(why, now); });
}

void PresenceGuard::on_tick() {
  change([](access::ObjectPresence& presence, TimePoint now) { return presence.on_tick(now); });
}

}  // namespace gecos::session
