// Waiting handlers: how describe() shows them, and how deadlocks between them are ended.
#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/session/server/handler_waits.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {

void ObjectHost::waits(ServerCall& call, const CommandId& awaited, std::string name) {
  const MutexLock lock(mutex_);
  if (!call.state.begun_at() || call.state.phase() == CallState::Phase::Finished) return;
  if (call.waits_for) return;
  call.waits_for = {awaited, std::move(name), runtime_->clock().now()};
  ++waiting_handlers_;
}

void ObjectHost::goes_on(ServerCall& call) {
  const MutexLock lock(mutex_);
  if (std::exchange(call.waits_for, std::nullopt)) --waiting_handlers_;
}

std::optional<CommandId> ObjectHost::awaited_by(const ServerCall& call) {
  const MutexLock lock(mutex_);
  return call.waits_for ? std::optional(call.waits_for->command) : std::nullopt;
}

std::shared_ptr<ServerCall> ObjectHost::find(const CommandId& call) {
  const MutexLock lock(mutex_);
  const auto session = outcomes_.open(SessionId{call.session});
  const auto* const found = session == nullptr ? nullptr : session->calls.find(call.counter);
  return found == nullptr ? nullptr : *found;
}

std::vector<std::shared_ptr<ServerCall>> ObjectHost::held_up_by(const ServerCall& call) {
  const MutexLock lock(mutex_);
  std::vector<std::shared_ptr<ServerCall>> holding;
  if (call.state.begun_at() || call.state.ended() || call.state.has_deadline()) return {};
  if (!call.state.queued()) {  // the servant begins its calls itself and has queued this call
    for (ServerCall* const handler : handlers_) {
      if (!servant_.gecos_share_thread(handler->operation(), call.operation())) continue;
      holding.push_back(handler->shared_from_this());
    }
    return holding;
  }
  if (!options_.thread_safe) {
    for (ServerCall* const handler : handlers_) {
      if (!handler->state.returned()) holding.push_back(handler->shared_from_this());
    }
  }
  if (call.lane == CallLane::Actor) {
    for (QueueEntry* const running : queue_.holding_up()) {
      holding.push_back(static_cast<ServerCall*>(running)->shared_from_this());
    }
  }
  return holding;
}

/// Handlers that wait for each other in a cycle without a time-out never return. Waits younger than
/// `certain_after` are not checked: the awaited call may be ending at this moment.
void ObjectHost::end_endless_waits(TimePoint now) {
  constexpr Duration certain_after = std::chrono::milliseconds(200);
  std::vector<std::shared_ptr<ServerCall>> waiting;
  {
    const MutexLock lock(mutex_);
    if (waiting_handlers_ == 0) return;
    for (ServerCall* const handler : handlers_) {
      const auto& wait = handler->waits_for;
      if (!wait || now - wait->since < certain_after) continue;
      waiting.push_back(handler->shared_from_this());
    }
  }
  for (const auto& handler : waiting) {
    const auto awaited = awaited_by(*handler);
    const auto object = awaited ? object_in(*awaited) : nullptr;
    if (object == nullptr) continue;
    if (const auto why = waits_for_itself(handler); !why.empty()) {
      object->refuse_endless(*awaited, why);
    }
  }
}

void ObjectHost::refuse_endless(const CommandId& id, const std::string& why) {
  const auto call = find(id);
  if (call == nullptr) return;
  const MutexLock lock(mutex_);
  if (call->state.ended() || call->state.begun_at()) return;
  const std::string text = call->title() + " was not started: " + why +
                           "; call the method itself, or let another thread wait";
  log_warning("server", text);
  end(*call, Failure{Detail::Rejected, text, {}, {}});  // a servant that queued the call drops it
  note_ready();
}

std::vector<RunningHandler> ObjectHost::running_handlers() {
  const TimePoint now = runtime_->clock().since_boot();
  std::vector<RunningHandler> handlers;
  for (const ServerCall* const call : handlers_) {
    RunningHandler& line = handlers.emplace_back();
    const Caller& caller = call->caller();
    line.operation = call->operation().name;
    line.running_for = std::chrono::duration<double>(now - *call->state.begun_at()).count();
    line.user = caller.user;
    line.host = caller.host;
    line.program = caller.program;
    line.pid = caller.pid;
    if (call->waits_for) line.waits_for = call->waits_for->name;
  }
  return handlers;
}

}  // namespace gecos::session
