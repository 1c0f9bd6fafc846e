// How an object reacts when the broker confirms its name, does not answer, or has assigned the name
// to another server.
#include "gecos/base/log.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {

bool ObjectHost::needs_name(const OperationDescription& operation) const {
  return (claim_.waits() || claim_.refuses()) && commands_the_object(operation);
}

void ObjectHost::claim_name() {
  const MutexLock lock(mutex_);
  claim_.ask();
}

std::uint64_t ObjectHost::name_question() {
  const MutexLock lock(mutex_);
  return claim_.question();
}

void ObjectHost::name_held(std::uint64_t question) {
  {
    const MutexLock lock(mutex_);
    const bool waited = claim_.waits();
    if (!claim_.held(question)) return;
    note_ready();
    if (waited) return;
  }
  log_info("session", name_ + ": the broker confirms the name; actor commands start again");
}

void ObjectHost::name_provisional() {
  const MutexLock lock(mutex_);
  claim_.provisional();
}

void ObjectHost::name_unanswered(std::uint64_t question, const std::string& why) {
  std::string text;
  {
    const MutexLock lock(mutex_);
    if (!claim_.unanswered(question, why)) return;
    text = "actor commands of " + name_ + " are not started: " + claim_.text();
    end_commands(
        [](const ServerCall& call) {
          return call.state.queued() && commands_the_object(call.operation());
        },
        Failure{Detail::NotStarted, text, {}, {}});
  }
  log_warning("session", text);
}

/// Interrupts running commands, even if their interface declares that they continue after the loss
/// of a lease.
void ObjectHost::name_taken(const std::string& by) {
  std::string why;
  {
    const MutexLock lock(mutex_);
    if (!claim_.taken(by)) return;
    why = claim_.text();
    leases_.stop(SessionId{}, why);
    end_commands([](const ServerCall& call) { return commands_the_object(call.operation()); },
                 Failure{Detail::Stopped, why, {}, {}});
    if (options_.on_stop) tell_user(options_.on_stop);
  }
  log_warning("session", name_ + " is stopped and takes no actor commands: " + why);
}

}  // namespace gecos::session
