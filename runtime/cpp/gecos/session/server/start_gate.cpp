#include "gecos/session/server/start_gate.hpp"

#include <utility>

#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

std::shared_ptr<ServerCall> StartGate::next(Starter starter) {
  ready_.store(false, std::memory_order_relaxed);
  if (setup_.pauses().suspected(setup_.clock(), pause_)) {
    calls_.note_ready();  // the maintenance thread starts the calls once it has judged the pause
    return nullptr;
  }
  while (auto call = take()) {
    const bool here = starter != Starter::Other && !setup_.runs_long(call->operation());
    if (may_start(*call) &&
        (!here || setup_.servant.gecos_begins_calls() || calls_.mark(*call, pause_.at))) {
      if (!here) calls_.list(*call);
      return call;
    }
    calls_.drop(*call);
  }
  return nullptr;
}

std::shared_ptr<ServerCall> StartGate::take() {
  if (awaited_ == 0 && !claim_.waits()) return calls_.take();
  const bool unconfirmed = claim_.waits() || claim_.refuses();
  return calls_.take([&](const ServerCall& call) {
    return !call.listener().heartbeats.awaited &&
           !(unconfirmed && commands_the_object(call.operation()));
  });
}

bool StartGate::may_start(ServerCall& call) {
  if (call.state.ended()) return false;
  const ServerSession& caller = call.listener();
  std::optional<Failure> late;
  if (call.state.has_deadline()) {
    const TimePoint now = setup_.clock().since_boot();
    if (call.state.overdue(now)) {
      late = not_in_time(call.operation(), call.state.misses_start(now));
    }
  }
  auto refusal = refusal_to_start({call.operation(), call.client, call.epoch, call.counter},
                                  statuses_.admitting(),
                                  {.gone = caller.closed && !caller.parted_in_order,
                                   .withdrawn = caller.intake.withdrawn(),
                                   .unheard = caller.heartbeats.awaited},
                                  std::move(late));
  if (!refusal && presence_.required()) {
    refusal =
        refusal_for_absence(call.operation(), setup_.name, presence_, setup_.clock().since_boot());
  }
  if (!refusal && call.operation().on_new == OnNew::Blend) {
    if (!call.left_out && caller.chain.broken()) {
      call.left_out = caller.chain.left_out(call.counter, call.title());
    }
    if (call.left_out) refusal = call.left_out->failure;
  }
  if (refusal) calls_.end(call, *refusal);
  return !refusal;
}

void StartGate::await_heartbeat(ServerSession& session) {
  if (session.closed) return;  // no heartbeat can arrive any more to end the wait
  session.heartbeats.before = session.connection().beats_seen();
  session.standing->set_unheard(true);
  if (!std::exchange(session.heartbeats.awaited, true)) ++awaited_;
}

void StartGate::await_no_more(ServerSession& session) {
  if (!std::exchange(session.heartbeats.awaited, false)) return;
  session.standing->set_unheard(false);
  --awaited_;
  calls_.note_ready();
}

}  // namespace gecos::session
