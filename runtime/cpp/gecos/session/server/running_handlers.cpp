#include "gecos/session/server/running_handlers.hpp"

#include <chrono>
#include <utility>

#include "gecos/base/seconds.hpp"
#include "gecos/session/server/server_call.hpp"

namespace gecos::session {

void RunningHandlers::add(ServerCall& call) { calls_.push_back(&call); }

void RunningHandlers::remove(ServerCall& call) {
  if (call.state.begun_at()) std::erase(calls_, &call);
  goes_on(call);
}

void RunningHandlers::waits(ServerCall& call, const CommandId& awaited, std::string name,
                            TimePoint now) {
  if (!call.state.begun_at() || call.state.phase() == CallState::Phase::Finished) return;
  if (call.waits_for) return;
  call.waits_for = {awaited, std::move(name), now};
  ++waiting_;
}

void RunningHandlers::goes_on(ServerCall& call) {
  if (std::exchange(call.waits_for, std::nullopt)) --waiting_;
}

std::vector<std::shared_ptr<ServerCall>> RunningHandlers::waiting_since(TimePoint before) const {
  std::vector<std::shared_ptr<ServerCall>> waiting;
  if (waiting_ == 0) return waiting;
  for (ServerCall* const call : calls_) {
    const auto& wait = call->waits_for;
    if (wait && wait->since <= before) waiting.push_back(call->shared_from_this());
  }
  return waiting;
}

std::vector<RunningHandler> RunningHandlers::shown(TimePoint since_boot) const {
  std::vector<RunningHandler> handlers;
  for (const ServerCall* const call : calls_) {
    RunningHandler& line = handlers.emplace_back();
    const Caller& caller = call->caller();
    line.operation = call->operation().name;
    line.running_for = to_seconds(since_boot - *call->state.begun_at());
    line.user = caller.user;
    line.host = caller.host;
    line.program = caller.program;
    line.pid = caller.pid;
    if (call->waits_for) line.waits_for = call->waits_for->name;
  }
  return handlers;
}

}  // namespace gecos::session
