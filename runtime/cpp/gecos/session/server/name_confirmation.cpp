#include "gecos/session/server/name_confirmation.hpp"

#include "gecos/base/log.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/host_state.hpp"

namespace gecos::session {

void NameConfirmation::ask() {
  const MutexLock lock(object_.mutex);
  object_.claim.ask();
}

std::uint64_t NameConfirmation::question() {
  const MutexLock lock(object_.mutex);
  return object_.claim.question();
}

void NameConfirmation::held(std::uint64_t question) {
  {
    const MutexLock lock(object_.mutex);
    const bool waited = object_.claim.waits();
    if (!object_.claim.held(question)) return;
    object_.calls.note_ready();
    if (waited) return;
  }
  log_info("session",
           object_.setup.name + ": the broker confirms the name; actor commands start again");
}

void NameConfirmation::provisional() {
  const MutexLock lock(object_.mutex);
  object_.claim.provisional();
}

void NameConfirmation::unanswered(std::uint64_t question, const std::string& why) {
  std::string text;
  {
    const MutexLock lock(object_.mutex);
    if (!object_.claim.unanswered(question, why)) return;
    text = "actor commands of " + object_.setup.name + " are not started: " + object_.claim.text();
    object_.calls.end_commands(
        [](const ServerCall& call) {
          return call.state.queued() && commands_the_object(call.operation());
        },
        Failure{Detail::NotStarted, text, {}, {}});
  }
  log_warning("session", text);
}

/// Interrupts running commands, even if their interface declares that they continue after the loss
/// of a lease.
void NameConfirmation::taken(const std::string& by) {
  const ObjectSetup& setup = object_.setup;
  std::string why;
  {
    const MutexLock lock(object_.mutex);
    if (!object_.claim.taken(by)) return;
    why = object_.claim.text();
    object_.statuses.stop(SessionId{}, why);
    object_.calls.end_commands(
        [](const ServerCall& call) { return commands_the_object(call.operation()); },
        Failure{Detail::Stopped, why, {}, {}});
    if (setup.options.on_stop) object_.user_callbacks.post(setup.options.on_stop);
  }
  log_warning("session", setup.name + " is stopped and takes no actor commands: " + why);
}

}  // namespace gecos::session
