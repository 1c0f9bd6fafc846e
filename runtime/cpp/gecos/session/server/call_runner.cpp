#include "gecos/session/server/call_runner.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/server/host_state.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

CallRunner::CallRunner(HostState& object)
    : object_(object), executor_("gecos-" + object.setup.name) {}

void CallRunner::run_ready(Starter starter, std::shared_ptr<ServerCall> started) {
  const auto next = [&] {
    const MutexLock lock(object_.mutex);
    return object_.starts.next(starter);
  };
  auto call = started ? std::move(started) : next();
  while (call) {
    if (starter == Starter::Other || object_.setup.runs_long(call->operation())) {
      // The job may use `this` later: `call` keeps its object alive, and the object owns this
      // CallRunner.
      const bool posted = executor_.post([this, call] {
        run_ready(Starter::Worker, begins(*call) ? execute(call, Starter::Worker) : nullptr);
      });
      if (!posted) not_begun(*call);
      call = next();
    } else {
      call = execute(call, starter);
    }
  }
}

/// Runs the handler of `call`. Returns the call that may start next, or null.
std::shared_ptr<ServerCall> CallRunner::execute(const std::shared_ptr<ServerCall>& call,
                                                Starter starter) {
  try {
    const RunsHere here(*call);
    object_.setup.servant.gecos_dispatch(IncomingCall(call));
  } catch (...) {  // the call was destroyed without an answer, so it ended as FAULT
    log_error("session",
              object_.setup.name + ": gecos_dispatch of the servant threw an exception for '" +
                  std::string(call->operation().name) +
                  "'; catch the exception in gecos_dispatch and fail the call with its text");
  }
  const MutexLock lock(object_.mutex);
  object_.calls.returned(call);
  return object_.starts.next(starter);
}

/// Returns false when the call ended before a thread took it, or when the call may no longer start.
/// In both cases the caller has its outcome, so the handler must not begin.
bool CallRunner::begins(ServerCall& call) {
  const MutexLock lock(object_.mutex);
  const TimePoint now = await_judgement();
  if (!object_.starts.may_start(call) ||
      (!object_.setup.servant.gecos_begins_calls() && !object_.calls.mark(call, now))) {
    object_.calls.drop(call);
    return false;
  }
  if (object_.setup.runs_long(call.operation())) {
    call.listener().report(call, Detail::Executing, 0);
  }
  return true;
}

bool CallRunner::begin(ServerCall& call) {
  runs_here(call.weak_from_this());
  const MutexLock lock(object_.mutex);
  const TimePoint now = await_judgement();
  if (call.state.begun_at()) return !call.state.ended();
  return object_.starts.may_start(call) && object_.calls.mark(call, now);
}

/// Ends and drops a call that the executor refused, because the object has ended or no thread can
/// be created.
void CallRunner::not_begun(ServerCall& call) {
  const MutexLock lock(object_.mutex);
  if (!call.state.ended()) {
    object_.calls.end(call, Failure{Detail::Rejected,
                                    "the call was not started: no thread could be created for its "
                                    "handler; raise the limit that `ulimit -u` shows for the user "
                                    "of the server",
                                    {},
                                    {}});
  }
  object_.calls.drop(call);
}

// The functions below are about pauses of this process.

/// Waits until every pause of this process is judged. Returns the moment (CLOCK_BOOTTIME) at which
/// no unjudged pause was found. The mutex is held from that moment on, so the caller may mark a
/// call as started at that moment.
TimePoint CallRunner::await_judgement() {
  const ObjectSetup& setup = object_.setup;
  for (;;) {
    const TimePoint now = setup.clock().since_boot();
    if (!setup.pauses().suspected(now)) return now;
    const MutexUnlock unlocked(object_.mutex);
    setup.pauses().await_judgement(setup.clock());
  }
}

/// Waits until the current pause of this process, if there is one, is judged.
/// ObjectHost::after_pause() then decides how a command that ran during the pause ends, even when
/// the handler answers right after the pause.
void CallRunner::let_pause_be_judged(const ServerCall& call) {
  const ObjectSetup& setup = object_.setup;
  if (!setup.runs_long(call.operation()) || call.lane != CallLane::Actor) return;
  if (!setup.runtime->maintenance().on_this_thread()) setup.pauses().await_judgement(setup.clock());
}

// The functions below process the answers of handlers.

void CallRunner::answered(ServerCall& call, ByteView result) {
  let_pause_be_judged(call);
  take_answer(call, result);
}

void CallRunner::answered(ServerCall& call, Failure failure) {
  let_pause_be_judged(call);
  if (failure.detail == Detail::Canceled) failure.text = "canceled while it was executing";
  if (project(failure.detail) == State::Running || failure.detail == Detail::Done) {
    failure.detail = Detail::Fault;
  }
  take_answer(call, failure);
}

template <class Outcome>
void CallRunner::take_answer(ServerCall& call, const Outcome& outcome) {
  {
    const MutexLock lock(object_.mutex);
    if (!object_.calls.answer(call, outcome)) return;
  }
  run_ready(Starter::Other);
}

void CallRunner::let_next(ServerCall& call) {
  {
    const MutexLock lock(object_.mutex);
    if (call.operation().on_new != OnNew::Blend || call.state.ended()) return;
    call.lets_next = true;
    object_.calls.note_ready();
  }
  run_ready(Starter::Other);
}

void CallRunner::progressed(ServerCall& call, double fraction, ByteView feedback) {
  const MutexLock lock(object_.mutex);
  object_.calls.progressed(call, fraction, feedback);
}

bool CallRunner::wait_interrupted(const ServerCall& call, TimePoint deadline) {
  {
    MutexLock lock(object_.mutex);
    object_.calls.wait_interrupted(lock, call, deadline);
  }
  let_pause_be_judged(call);
  return call.interrupted();
}

}  // namespace gecos::session
