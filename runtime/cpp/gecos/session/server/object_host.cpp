#include "gecos/session/server/object_host.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/sample_time.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/host_state.hpp"

namespace gecos::session {

ObjectHost::ObjectHost(std::shared_ptr<Runtime> runtime, std::string name, Servant& servant,
                       ObjectOptions options, std::shared_ptr<audit::Audit> audit,
                       UserRights rights, std::string zone)
    : state_({std::move(runtime), name, servant, servant.gecos_interface(), std::move(options),
              std::make_shared<ObjectAudit>(name, std::move(audit)), std::move(rights),
              std::move(zone)}),
      waits_(state_),
      name_confirmation_(state_),
      presence_(state_),
      streams_(state_.setup.name, state_.setup.interface),
      inward_(state_.setup, state_.claim, state_.presence),
      runner_(state_) {}

PeerLiveness::Bounds ObjectHost::bounds_of_clients() const {
  const Runtime& runtime = *state_.setup.runtime;
  return {.suspect_after = runtime.options().lease_ttl, .dead_after = runtime.registration_ttl()};
}

void ObjectHost::take(const std::shared_ptr<ServerSession>& session, ByteView packet) {
  const MutexLock lock(state_.mutex);
  state_.packets.take(session, packet);
}

std::shared_ptr<ServerCall> ObjectHost::take_and_start(
    const std::shared_ptr<ServerSession>& session, ByteView packet, Starter starter) {
  const MutexLock lock(state_.mutex);
  state_.packets.take(session, packet);
  return ready() ? state_.starts.next(starter) : nullptr;
}

// The functions below handle silent clients and lost connections.

void ObjectHost::await_sign_of_life(ServerSession& session) {
  const MutexLock lock(state_.mutex);
  session.heartbeats.liveness.await_heartbeat_after(session.connection().beats_seen());
  state_.starts.await_heartbeat(session);
}

bool ObjectHost::check_liveness(const std::shared_ptr<ServerSession>& session) {
  const MutexLock lock(state_.mutex);
  if (session->sender().overrun()) return true;
  const TimePoint now = state_.statuses.advance(state_.setup.clock().now());
  const auto verdict = session->heartbeats.liveness.check(session->connection().beats_seen(), now);
  // The connection may contain an unread Goodbye that the client sent before the heartbeat and that
  // withdraws calls. That Goodbye must be read first.
  const bool heard = session->connection().beats_read() > session->heartbeats.before;
  if (heard && verdict <= PeerLiveness::Verdict::Quiet) state_.starts.await_no_more(*session);
  if (verdict == PeerLiveness::Verdict::Quiet) return false;
  if (verdict == PeerLiveness::Verdict::Alive) {
    state_.statuses.renew(*session, now);
    return false;
  }
  // A silent client may have withdrawn its calls. The server cannot know this before the next
  // heartbeat, so no call of the client starts before that heartbeat.
  if (session->repeats()) state_.starts.await_heartbeat(*session);
  return verdict == PeerLiveness::Verdict::Dead;
}

void ObjectHost::depart(const std::shared_ptr<ServerSession>& session, Departure how,
                        const std::string& because) {
  bool calls_are_over = false;
  {
    const MutexLock lock(state_.mutex);
    if (std::exchange(session->closed, true)) return;
    session->parted_because = because;
    const bool in_order = how == Departure::InOrder || session->left;
    session->parted_in_order = in_order;
    state_.starts.await_no_more(*session);
    state_.statuses.depart(*session, in_order);
    state_.packets.depart(*session);
    session->subscriptions.clear();
    if (session->greeted()) inward_.depart(session->id());
    if (session->greeted()) {
      if (log_enabled(LogLevel::Info)) log_departure(name(), *session);
      state_.setup.audit->disconnected(*session, session->left ? "" : because);
      state_.calls.outcomes().closed(session->id(), session->intake.window(),
                                     in_order ? nullptr : session);
    }
    calls_are_over = session->unreturned == 0;
  }
  if (!session->greeted() || !calls_are_over) return;
  state_.user_callbacks.run(
      [&] { state_.setup.servant.gecos_session_ended(number(session->id())); });
}

// The maintenance thread calls the functions below.

void ObjectHost::after_pause(Duration stood_still) {
  {
    const MutexLock lock(state_.mutex);
    state_.calls.end_commands(
        [](const ServerCall& call) { return !call.state.queued(); },
        Failure{Detail::Fault,
                "the server " + stood_still_for(stood_still) + " while the command was running",
                {},
                {}});
  }
  presence_.forget("the server of the object " + stood_still_for(stood_still));
  const MutexLock lock(state_.mutex);
  if (state_.claim.standing() == NameClaim::Standing::Unregistered) return;
  if (stood_still > state_.setup.runtime->registration_ttl()) state_.claim.ask();
}

TimePoint ObjectHost::on_tick(TimePoint now) {
  {
    const MutexLock lock(state_.mutex);
    state_.statuses.on_tick(now);
    state_.calls.on_tick(now);
    state_.setup.audit->on_tick();
  }
  presence_.on_tick();
  waits_.end_endless(now);
  // If the client of a call is gone or the polling thread sleeps, no other thread starts the calls
  // that can start now.
  if (ready()) run_ready(Starter::Other);
  const MutexLock lock(state_.mutex);
  if (!state_.calls.idle()) return now + Maintenance::tick;
  const bool waits = state_.statuses.somebody_waits() || state_.presence.required();
  return waits ? now + Maintenance::calm_tick : TimePoint::max();
}

// The functions below are about the end of an object.

void ObjectHost::close() {
  served_.store(false, std::memory_order_relaxed);
  const MutexLock lock(state_.mutex);
  state_.packets.close();
  state_.calls.end_all(Failure{Detail::Stopped, "the server no longer serves " + name(), {}, {}});
  state_.statuses.close();
  state_.setup.audit->end();
}

std::string ObjectHost::served_as() {
  return served_.load(std::memory_order_relaxed) && getpid() == owner_ ? name() : std::string();
}

bool ObjectHost::closed() {
  const MutexLock lock(state_.mutex);
  return state_.packets.closed();
}

void ObjectHost::join() {
  runner_.join();
  state_.passwords.join();
  state_.user_callbacks.end();
}

void ObjectHost::publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) {
  streams_.publish(stream, sample, sample_time(stamp_ns, state_.setup.clock()));
}

bool ObjectHost::publish_lent(const StreamDescription& stream, const LentMemory& memory,
                              std::int64_t stamp_ns) {
  return streams_.publish_lent(stream, memory, sample_time(stamp_ns, state_.setup.clock()));
}

}  // namespace gecos::session
