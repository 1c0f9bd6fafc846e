#include "gecos/session/server/object_host.hpp"

#include <algorithm>
#include <exception>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/start_words.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/handler_waits.hpp"

namespace gecos::session {

namespace {

/// Runs a callback of the user and logs any exception that it throws, because no caller can catch
/// it.
void run_for_user(const std::string& object, const std::function<void()>& what) {
  try {
    what();
  } catch (const std::exception& error) {
    log_error("session", object + ": on_stop or gecos_session_ended threw: " + error.what());
  } catch (...) {
    log_error(
        "session",
        object + ": on_stop or gecos_session_ended threw something that is no std::exception");
  }
}

}  // namespace

ObjectHost::ObjectHost(std::shared_ptr<Runtime> runtime, std::string name, Servant& servant,
                       ObjectOptions options)
    : runtime_(std::move(runtime)),
      name_(std::move(name)),
      servant_(servant),
      interface_(servant.gecos_interface()),
      options_(std::move(options)),
      leases_(process_incarnation(), runtime_->options().lease_ttl),
      queue_(options_.thread_safe ? LaneThreads::Many : LaneThreads::One),
      lease_clock_(runtime_->clock().now(), runtime_->options().heartbeat * 2),
      streams_(name_, interface_),
      executor_("gecos-" + name_) {}

// Running handlers

void ObjectHost::run_ready(Starter starter, std::shared_ptr<ServerCall> started) {
  const auto next = [&] {
    const MutexLock lock(mutex_);
    return start_next(starter);
  };
  auto call = started ? std::move(started) : next();
  while (call) {
    if (starter == Starter::Other || runs_long(call->operation())) {
      const bool posted = executor_.post([self = shared_from_this(), call] {
        self->run_ready(Starter::Worker,
                        self->begins(*call) ? self->execute(call, Starter::Worker) : nullptr);
      });
      if (!posted) not_begun(*call);
      call = next();
    } else {
      call = execute(call, starter);
    }
  }
}

std::shared_ptr<ServerCall> ObjectHost::execute(const std::shared_ptr<ServerCall>& call,
                                                Starter starter) {
  try {
    const RunsHere here(*call);
    servant_.gecos_dispatch(IncomingCall(call));
  } catch (...) {  // the servant dropped the call unanswered, so the call ended as FAULT
    log_error("session", name_ + ": the servant threw while it dispatched '" +
                             std::string(call->operation().name) +
                             "'; catch the exception there and fail the call with its text");
  }
  const MutexLock lock(mutex_);
  const auto change = call->state.on(CallState::Event::Return);
  queue_.returned(*call);
  if (change.finished) {
    finished(*call);
  } else if (!call->state.ended()) {
    list(*call);  // the handler answers later
    call->listener().report(*call, Detail::Executing, 0);
  }
  return start_next(starter);
}

/// Returns false for a call that ended before a thread took it, or that may no longer start: its
/// caller was notified, so its handler must not begin.
bool ObjectHost::begins(ServerCall& call) {
  const MutexLock lock(mutex_);
  const TimePoint now = await_judgement();
  if (!may_start(call) || (!servant_.gecos_begins_calls() && !marked(call, now))) {
    never_began(call);
    return false;
  }
  if (runs_long(call.operation())) call.listener().report(call, Detail::Executing, 0);
  return true;
}

bool ObjectHost::begin(ServerCall& call) {
  runs_here(call.weak_from_this());
  const MutexLock lock(mutex_);
  const TimePoint now = await_judgement();
  if (call.state.begun_at()) return !call.state.ended();
  return may_start(call) && marked(call, now);
}

/// Waits until every pause is judged. Returns the CLOCK_BOOTTIME at which no unjudged pause was
/// found. The mutex is held from that moment on, so the caller may mark a call with this time.
TimePoint ObjectHost::await_judgement() {
  PauseWatch& pauses = runtime_->maintenance().pauses();
  for (;;) {
    const TimePoint now = runtime_->clock().since_boot();
    if (!pauses.suspected(now)) return now;
    const MutexUnlock unlocked(mutex_);
    pauses.await_judgement(runtime_->clock());
  }
}

/// Drops a call that the executor refused, because the object has ended or no thread can be
/// created.
void ObjectHost::not_begun(ServerCall& call) {
  const MutexLock lock(mutex_);
  if (!call.state.ended()) {
    end(call, Failure{Detail::Rejected,
                      "the call was not started: no thread could be created for its handler, see "
                      "`ulimit -u` of the server",
                      {},
                      {}});
  }
  never_began(call);
}

void ObjectHost::never_began(ServerCall& call) {
  call.state.on(CallState::Event::Drop);
  queue_.returned(call);
  finished(call);
}

std::shared_ptr<ServerCall> ObjectHost::start_next(Starter starter) {
  ready_.store(false, std::memory_order_relaxed);
  if (runtime_->maintenance().pauses().suspected(runtime_->clock(), pause_)) {
    note_ready();  // the maintenance thread starts these calls once it has judged the pause
    return nullptr;
  }
  while (auto entry = next_entry()) {
    auto call = std::static_pointer_cast<ServerCall>(std::move(entry));
    call->state.on(CallState::Event::Take);
    const bool here = starter != Starter::Other && !runs_long(call->operation());
    if (may_start(*call) && (!here || servant_.gecos_begins_calls() || marked(*call, pause_.at))) {
      if (!here) list(*call);
      return call;
    }
    never_began(*call);
  }
  return nullptr;
}

std::shared_ptr<QueueEntry> ObjectHost::next_entry() {
  if (awaited_ == 0 && !claim_.waits()) return queue_.next();
  return queue_.next([this](const QueueEntry& entry) {
    mutex_.assert_held();
    return !static_cast<const ServerCall&>(entry).listener().awaited &&
           !needs_name(entry.operation);
  });
}

/// Whether `call` may start; ends the call when it may not.
bool ObjectHost::may_start(ServerCall& call) {
  if (call.state.ended()) return false;
  const ServerSession& caller = call.listener();
  const bool expired =
      call.state.has_deadline() && call.state.overdue(runtime_->clock().since_boot());
  const auto refusal = refusal_to_start({call.operation(), call.client, call.epoch}, as_asked(),
                                        {.gone = caller.closed && !caller.parted_in_order,
                                         .withdrawn = caller.intake.withdrawn(),
                                         .unheard = caller.awaited},
                                        expired);
  if (refusal) end(call, *refusal);
  return !refusal;
}

/// Marks `call` as started; must be called directly before its handler begins. Returns false when
/// the client has withdrawn the call and therefore reports it as not started.
bool ObjectHost::marked(ServerCall& call, TimePoint now) {
  call.note_mark(now);
  if (!withdrawn(call)) {
    call.state.on(CallState::Event::Begin, now);
    handlers_.push_back(&call);
    if (log_enabled(LogLevel::Debug)) log_begin(call);
    return true;
  }
  end(call, Failure{Detail::NotStarted,
                    "'" + std::string(call.operation().name) + "' of " + name_ +
                        " was not started: its caller had given it up",
                    {},
                    {}});
  return false;
}

/// Whether the client has withdrawn `call`. When client and server share memory, the mark must be
/// written before the withdrawal is read.
bool ObjectHost::withdrawn(const ServerCall& call) {
  ServerSession& session = call.listener();
  if (!session.connection().capabilities().shared_words) return false;
  const std::uint64_t counter = call.counter_in(session);
  const std::size_t word = marked_word(call.lane);
  session.marked.at(word) = std::max(session.marked.at(word), counter);
  session.connection().write_word(word, session.marked.at(word));
  return session.connection().peer_word(withdrawn_word) >= counter;
}

// Answers and outcomes

void ObjectHost::answered(ServerCall& call, ByteView result) {
  let_pause_be_judged(call);
  take_answer(call, result);
}

void ObjectHost::answered(ServerCall& call, Failure failure) {
  let_pause_be_judged(call);
  if (failure.detail == Detail::Canceled) failure.text = "canceled while it was executing";
  if (project(failure.detail) == State::Running || failure.detail == Detail::Done) {
    failure.detail = Detail::Fault;
  }
  take_answer(call, failure);
}

template <class Outcome>
void ObjectHost::take_answer(ServerCall& call, const Outcome& outcome) {
  {
    const MutexLock lock(mutex_);
    const auto change = call.state.on(CallState::Event::Answer);
    if (change.report) tell_outcome(call, outcome);
    if (!change.finished) return;
    finished(call);
  }
  run_ready(Starter::Other);
}

/// Waits until a pause is judged, so that a command that ran during the pause ends as after_pause()
/// decides, even when its handler answers at once.
void ObjectHost::let_pause_be_judged(const ServerCall& call) {
  if (!runs_long(call.operation()) || call.lane != CallLane::Actor) return;
  Maintenance& maintenance = runtime_->maintenance();
  if (!maintenance.on_this_thread()) maintenance.pauses().await_judgement(runtime_->clock());
}

void ObjectHost::end(ServerCall& call, const Failure& failure) {
  if (call.state.queued()) queue_.remove(call);
  const auto change = call.state.on(CallState::Event::End);
  tell_outcome(call, failure);
  if (change.finished) finished(call);
}

void ObjectHost::tell_outcome(ServerCall& call, ByteView result) {
  settle(call, Detail::Done, {});
  call.listener().reply(call.counter_in(call.listener()), result);
}

void ObjectHost::tell_outcome(ServerCall& call, const Failure& failure) {
  settle(call, failure.detail, failure.text);
  call.listener().reply(call.counter_in(call.listener()), failure);
}

/// Records the end of `call`. Must be called before the reply is sent, so that the status can be
/// acquired as soon as a client sees its last command end. Commands of the next holder still wait
/// for the handler to return.
void ObjectHost::settle(ServerCall& call, Detail detail, const std::string& text) {
  if (log_enabled(level_of(call.operation()))) log_end(call, detail, text, runtime_->clock().now());
  call.session->calls.take(call.counter);
  if (call.resumed_in) call.resumed_in->calls.take(call.resumed_counter);
  if (call.lane != CallLane::Actor) return;
  outcomes_.ended({call.client, call.counter, detail, text});
  if (--call.session->commands == 0) leases_.drained(call.client);
}

void ObjectHost::list(ServerCall& call) {
  if (!std::exchange(call.listed, true)) open_.push_back(call.shared_from_this());
}

/// Must be called when the handler of `call` has answered and returned: frees the lane of the call.
void ObjectHost::finished(ServerCall& call) {
  queue_.ended(call);
  if (call.state.begun_at()) std::erase(handlers_, &call);
  if (std::exchange(call.waits_for, std::nullopt)) --waiting_handlers_;
  if (std::exchange(call.listed, false)) {
    open_.erase(std::find_if(open_.begin(), open_.end(),
                             [&](const auto& other) { return other.get() == &call; }));
  }
  grant_to_waiting();
  ServerSession& session = *call.session;
  if (--session.unreturned != 0 || !session.closed) return;
  tell_user([this, id = number(session.id())] { servant_.gecos_session_ended(id); });
}

void ObjectHost::tell_user(std::function<void()> what) {
  runtime_->maintenance().post([weak = weak_from_this(), what = std::move(what)] {
    const auto self = weak.lock();
    if (self == nullptr) return;
    const MutexLock lock(self->user_mutex_);
    if (!self->joined_) run_for_user(self->name_, what);
  });
}

/// The running and queued actor commands, in the order in which they start.
std::vector<std::shared_ptr<ServerCall>> ObjectHost::actor_commands() const {
  std::vector<std::shared_ptr<ServerCall>> commands;
  for (QueueEntry* entry : queue_.running()) {
    commands.push_back(static_cast<ServerCall*>(entry)->shared_from_this());
  }
  for (const auto& entry : queue_.waiting()) {
    commands.push_back(std::static_pointer_cast<ServerCall>(entry));
  }
  return commands;
}

void ObjectHost::interrupt(ServerCall& call) {
  call.interrupt();
  interrupted_.notify_all();
}

bool ObjectHost::wait_interrupted(const ServerCall& call, TimePoint deadline) {
  const auto wanted = [&] { return call.interrupted(); };
  {
    MutexLock lock(mutex_);
    if (deadline != TimePoint::max()) {
      interrupted_.wait_until(lock, deadline, wanted);
    } else {
      interrupted_.wait(lock, wanted);
    }
  }
  let_pause_be_judged(call);
  return wanted();
}

void ObjectHost::end_commands(const std::function<bool(const ServerCall&)>& which,
                              const Failure& failure) {
  for (const auto& call : actor_commands()) {
    if (!which(*call)) continue;
    if (!call->state.queued()) interrupt(*call);
    if (!call->state.ended()) end(*call, failure);
  }
  note_ready();
}

void ObjectHost::progressed(ServerCall& call, double fraction, ByteView feedback) {
  const MutexLock lock(mutex_);
  if (call.state.ended()) return;
  call.reported.note(fraction, feedback);
  tell(call, runtime_->clock().now());
}

void ObjectHost::tell(ServerCall& call, TimePoint now) {
  if (call.state.ended() || !call.reported.due(now)) return;
  const Detail detail = call.state.canceling() ? Detail::Canceling : Detail::Executing;
  if (call.listener().report(call, detail, 0)) call.reported.sent(now);
}

void ObjectHost::tell_positions() {
  std::size_t position = queue_.running().size();
  for (const auto& entry : queue_.waiting()) {
    auto& call = static_cast<ServerCall&>(*entry);
    if (call.position_sent != position && call.listener().report(call, Detail::Queued, position)) {
      call.position_sent = position;
    }
    ++position;
  }
}

// Deadlines, silent clients and lost connections

TimePoint ObjectHost::on_tick(TimePoint now) {
  look_at_time(now);
  end_endless_waits(now);
  // Starts calls that can start now and that no other thread starts, because the client is gone or
  // the polling thread sleeps.
  if (ready()) run_ready(Starter::Other);
  const MutexLock lock(mutex_);
  const bool calm = queue_.idle() && open_.empty();
  return now + (calm ? Maintenance::calm_tick : Maintenance::tick);
}

void ObjectHost::look_at_time(TimePoint now) {
  const MutexLock lock(mutex_);
  for (const auto& holder : leases_.expire(lease_clock_.advance(now))) {
    lose_status(holder.session,
                "its holder has been silent for " +
                    std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(
                                       runtime_->options().lease_ttl)
                                       .count()) +
                    " ms");
  }
  const auto open = open_;
  const TimePoint by_deadlines = open.empty() ? now : runtime_->clock().since_boot();
  for (const auto& call : open) {
    if (!call->state.ended() && call->state.overdue(by_deadlines)) {
      if (call->state.queued()) {
        end(*call, Failure{Detail::Expired,
                           "the deadline of '" + std::string(call->operation().name) +
                               "' passed before it started; it was not carried out",
                           {},
                           {}});
      } else {
        interrupt(*call);
        end(*call, Failure{Detail::TimedOut,
                           "the deadline of '" + std::string(call->operation().name) +
                               "' passed while it was executing; it was told to stop",
                           {},
                           {}});
      }
      note_ready();
    }
    tell(*call, now);
  }
  tell_positions();
  if (!waiting_.empty()) refuse_waiting(now);
}

void ObjectHost::await_sign_of_life(ServerSession& session) {
  const MutexLock lock(mutex_);
  session.liveness.await_heartbeat_after(session.connection().beats_seen());
  await_heartbeat(session);
}

void ObjectHost::await_heartbeat(ServerSession& session) {
  if (session.closed) return;  // no heartbeat can arrive any more to end the wait
  session.heartbeats_before = session.connection().beats_seen();
  if (!std::exchange(session.awaited, true)) ++awaited_;
}

void ObjectHost::no_more_awaited(ServerSession& session) {
  if (!std::exchange(session.awaited, false)) return;
  --awaited_;
  note_ready();
}

void ObjectHost::after_pause(Duration stood_still) {
  const MutexLock lock(mutex_);
  end_commands(
      [](const ServerCall& call) { return !call.state.queued(); },
      Failure{Detail::Fault,
              "the server " + stood_still_for(stood_still) + " while the command was running",
              {},
              {}});
  if (claim_.standing() == NameClaim::Standing::Unregistered) return;
  if (stood_still > runtime_->registration_ttl()) claim_.ask();
}

bool ObjectHost::check_liveness(const std::shared_ptr<ServerSession>& session) {
  const MutexLock lock(mutex_);
  if (session->overrun()) return true;
  const TimePoint now = lease_clock_.now();
  const auto verdict = session->liveness.check(session->connection().beats_seen(), now);
  // The connection may hold an unread Goodbye that was sent before the heartbeat and withdraws
  // calls. It must be read first.
  const bool heard = session->connection().beats_read() > session->heartbeats_before;
  if (heard && verdict <= PeerLiveness::Verdict::Quiet) no_more_awaited(*session);
  if (verdict == PeerLiveness::Verdict::Quiet) return false;
  if (verdict == PeerLiveness::Verdict::Alive) {
    leases_.renew(session->id(), now);
    return false;
  }
  // A silent client may have withdrawn its calls. The server cannot know that before the next
  // heartbeat, so no call starts until then.
  if (session->repeats()) await_heartbeat(*session);
  return verdict == PeerLiveness::Verdict::Dead;
}

void ObjectHost::depart(const std::shared_ptr<ServerSession>& session, Departure how) {
  bool calls_are_over = false;
  {
    const MutexLock lock(mutex_);
    if (std::exchange(session->closed, true)) return;
    session->parted_in_order = how == Departure::InOrder || session->left;
    no_more_awaited(*session);
    leases_.forget(session->id());
    std::erase_if(waiting_, [&](const auto& waiting) { return waiting.session == session; });
    if (how == Departure::InOrder || session->left) {
      release_all(*session);
    } else if (leases_.lose(session->id())) {
      lose_status(session->id(), "its holder (" + session->caller().program + ", pid " +
                                     std::to_string(session->caller().pid) + ") is gone");
    }
    // Calls that were issued before these deferred calls are missing and will not arrive any more.
    while (const auto counter = session->intake.first_aside()) {
      end_early(
          *session, *counter, Detail::Rejected,
          "the call was not started: the session ended before the calls issued earlier arrived");
    }
    session->subscriptions.clear();
    if (session->greeted()) {
      if (log_enabled(LogLevel::Info)) log_departure(name_, *session);
      const bool lost = how == Departure::Lost && !session->left;
      outcomes_.closed(session->id(), session->intake.window(), lost ? session : nullptr);
    }
    calls_are_over = session->unreturned == 0;
  }
  if (!session->greeted() || !calls_are_over) return;
  run_for_user(name_, [&] { servant_.gecos_session_ended(number(session->id())); });
}

void ObjectHost::lose_status(SessionId session, const std::string& why) {
  log_info("server", name_ + ": a status ended: " + why);
  const Failure failure{
      Detail::LeaseLost, "the status under which the command was issued ended: " + why, {}, {}};
  end_commands(
      [&](const ServerCall& call) {
        return call.client == session && call.operation().status != access::Status::Sensor &&
               (call.state.queued() || call.operation().on_loss != OnLoss::Finish);
      },
      failure);
}

void ObjectHost::release_all(ServerSession& session) {
  using Commands = access::LeaseTable::Commands;
  while (leases_.status_of(session.id()) != access::Status::Sensor &&
         !leases_.releasing(session.id())) {
    leases_.release(session.id(), leases_.epoch(),
                    session.commands != 0 ? Commands::Pending : Commands::None);
  }
}

void ObjectHost::close() {
  const MutexLock lock(mutex_);
  closed_ = true;
  const Failure failure{Detail::Stopped, "the server no longer serves " + name_, {}, {}};
  end_commands([](const ServerCall&) { return true; }, failure);
  for (const auto& entry : queue_.drop()) {
    end(static_cast<ServerCall&>(*entry), failure);
  }
  for (const auto& waiting : std::exchange(waiting_, {})) {
    waiting.session->reply(waiting.counter,
                           Failure{Detail::Rejected, "the server is about to end", {}, {}});
  }
  const auto open = open_;  // the remaining calls are sensor operations that are answered later
  for (const auto& call : open) {
    interrupt(*call);
    if (!call->state.ended()) end(*call, failure);
  }
}

bool ObjectHost::closed() {
  const MutexLock lock(mutex_);
  return closed_;
}

void ObjectHost::join() {
  executor_.join();
  const MutexLock lock(user_mutex_);
  joined_ = true;
}

void ObjectHost::publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) {
  streams_.publish(stream, sample, sample_time(stamp_ns, runtime_->clock()));
}

}  // namespace gecos::session
