#include "gecos/session/server/object_calls.hpp"

#include <algorithm>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/start_words.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {
namespace {

/// Returns whether the client has withdrawn `call`. If client and server share memory, writes the
/// mark of the call first: the mark must be written before the withdrawal is read.
bool withdrawn(const ServerCall& call) {
  ServerSession& session = call.listener();
  if (!session.connection().capabilities().shared_words) return false;
  const std::uint64_t counter = call.counter_in(session);
  const std::size_t word = marked_word(call.lane);
  session.marked.at(word) = std::max(session.marked.at(word), counter);
  session.connection().write_word(word, session.marked.at(word));
  return session.connection().peer_word(withdrawn_word) >= counter;
}

/// Returns the running and queued actor commands, in the order in which they start.
std::vector<std::shared_ptr<ServerCall>> commands_of(const ObjectQueue& queue) {
  std::vector<std::shared_ptr<ServerCall>> commands;
  for (QueueEntry* entry : queue.running()) {
    commands.push_back(static_cast<ServerCall*>(entry)->shared_from_this());
  }
  for (const auto& entry : queue.waiting()) {
    commands.push_back(std::static_pointer_cast<ServerCall>(entry));
  }
  return commands;
}

/// Returns whether a command that ends as `detail` ends because of an event that also ends the
/// queued commands of its client, for example a cancel, a stop or the loss of the status.
bool ends_queued_commands_too(Detail detail) {
  return detail == Detail::Canceled || detail == Detail::Stopped || detail == Detail::Preempted ||
         detail == Detail::LeaseLost || detail == Detail::PresenceLost;
}

void tell_progress(ServerCall& call, TimePoint now) {
  if (call.state.ended() || !call.reported.due(now)) return;
  const Detail detail = call.state.canceling() ? Detail::Canceling : Detail::Executing;
  if (call.listener().report(call, detail, 0)) call.reported.sent(now);
}

void tell_positions(const ObjectQueue& queue) {
  std::size_t position = queue.running().size();
  for (const auto& entry : queue.waiting()) {
    auto& call = static_cast<ServerCall&>(*entry);
    if (call.position_sent != position && call.listener().report(call, Detail::Queued, position)) {
      call.position_sent = position;
    }
    ++position;
  }
}

}  // namespace

// The functions below take a call from the queue to the end of its handler.

tl::expected<std::size_t, ObjectQueue::Full> ObjectCalls::add(std::shared_ptr<ServerCall> added) {
  const auto commands_before = queue_.push(added);
  if (!commands_before) return commands_before;
  ServerCall& call = *added;
  statistics_.queued(call);
  ServerSession& session = *call.session;
  session.calls.insert(call.counter, std::move(added));
  ++session.unreturned;
  if (call.lane == CallLane::Actor) ++session.commands;
  if (call.state.has_deadline()) list(call);
  note_ready();
  return commands_before;
}

std::shared_ptr<ServerCall> ObjectCalls::take() {
  auto call = std::static_pointer_cast<ServerCall>(queue_.next());
  if (call) call->state.on(CallState::Event::Take);
  return call;
}

std::shared_ptr<ServerCall> ObjectCalls::take(FunctionRef<bool(const ServerCall&)> wanted) {
  auto call = std::static_pointer_cast<ServerCall>(queue_.next(
      [&](const QueueEntry& entry) { return wanted(static_cast<const ServerCall&>(entry)); }));
  if (call) call->state.on(CallState::Event::Take);
  return call;
}

bool ObjectCalls::mark(ServerCall& call, TimePoint since_boot) {
  call.note_mark(since_boot);
  if (!withdrawn(call)) {
    call.state.on(CallState::Event::Begin, since_boot);
    handlers_.add(call);
    statistics_.begins(call, since_boot, setup_.runs_long(call.operation()));
    if (log_enabled(LogLevel::Debug)) log_begin(call);
    setup_.audit->begins(call);
    return true;
  }
  end(call, Failure{Detail::NotStarted,
                    "'" + std::string(call.operation().name) + "' of " + setup_.name +
                        " was not started: the caller had given the call up",
                    {},
                    {}});
  return false;
}

void ObjectCalls::drop(ServerCall& call) {
  call.state.on(CallState::Event::Drop);
  queue_.returned(call);
  finished(call);
}

void ObjectCalls::returned(const std::shared_ptr<ServerCall>& call) {
  const auto change = call->state.on(CallState::Event::Return);
  queue_.returned(*call);
  if (change.finished) {
    finished(*call);
  } else if (!call->state.ended()) {
    list(*call);  // the handler answers later
    call->listener().report(*call, Detail::Executing, 0);
  }
}

/// Releases the lane of `call`. Must be called when the handler of `call` has answered and
/// returned.
void ObjectCalls::finished(ServerCall& call) {
  queue_.ended(call);
  handlers_.remove(call);
  statistics_.finished(call);
  if (std::exchange(call.listed, false)) {
    open_.erase(std::find_if(open_.begin(), open_.end(),
                             [&](const auto& other) { return other.get() == &call; }));
  }
  observer_.finished(call);
}

// The functions below are about the outcomes of calls.

void ObjectCalls::tell_outcome(ServerCall& call, ByteView result) {
  settle(call, Detail::Done, {});
  call.session->chain.succeeded(call.counter);
  call.listener().reply(call.counter_in(call.listener()), result);
}

void ObjectCalls::tell_outcome(ServerCall& call, const Failure& failure) {
  // A handler that was interrupted because an earlier command with @on_new("blend") failed answers
  // CANCELED. The caller gets the earlier failure as the reason instead.
  const bool interrupted = call.left_out && failure.detail == Detail::Canceled;
  const Failure& reported = interrupted ? call.left_out->failure : failure;
  settle(call, reported.detail, reported.text);
  call.listener().reply(call.counter_in(call.listener()), reported,
                        call.left_out ? call.left_out->because_of : 0);
  break_chain(call, reported);
}

/// If `call`, which has failed, has @on_new("blend"), leaves out the later commands with
/// @on_new("blend") of the same session (BlendChain): ends those that are queued, and interrupts
/// those that have begun.
void ObjectCalls::break_chain(ServerCall& call, const Failure& failure) {
  if (call.operation().on_new != OnNew::Blend || call.left_out) return;
  BlendChain& chain = call.session->chain;
  chain.failed({call.counter, std::string(call.operation().name), failure.detail, failure.text});
  if (ends_queued_commands_too(failure.detail)) return;
  for (const auto& later : commands_of(queue_)) {
    if (later->session != call.session || later->operation().on_new != OnNew::Blend) continue;
    if (later->state.ended() || later->left_out) continue;
    later->left_out = chain.left_out(later->counter, later->title());
    if (!later->left_out) continue;
    if (later->state.queued()) {
      end(*later, later->left_out->failure);
    } else {
      interrupt(*later);
    }
  }
  note_ready();
}

/// Records the end of `call`. Must be called before the reply is sent, so that a client that sees
/// the end of its last command can acquire the status at once. Commands of the next holder still
/// wait until the handler has returned.
void ObjectCalls::settle(ServerCall& call, Detail detail, const std::string& text) {
  if (log_enabled(level_of(call.operation()))) log_end(call, detail, text, setup_.clock().now());
  setup_.audit->ended(call, detail, text);
  statistics_.ended(call, detail);
  call.session->calls.take(call.counter);
  if (call.resumed_in) call.resumed_in->calls.take(call.resumed_counter);
  if (call.lane != CallLane::Actor) return;
  outcomes_.ended(call.session->id(), call.counter, detail, text);
  if (--call.session->commands == 0) observer_.commands_ended(call.client);
}

void ObjectCalls::end(ServerCall& call, const Failure& failure) {
  if (call.state.queued()) queue_.remove(call);
  const auto change = call.state.on(CallState::Event::End);
  tell_outcome(call, failure);
  if (change.finished) finished(call);
}

void ObjectCalls::end_commands(FunctionRef<bool(const ServerCall&)> which, const Failure& failure) {
  for (const auto& call : commands_of(queue_)) {
    if (!which(*call)) continue;
    if (!call->state.queued()) interrupt(*call);
    if (!call->state.ended()) end(*call, failure);
  }
  note_ready();
}

void ObjectCalls::end_all(const Failure& failure) {
  end_commands([](const ServerCall&) { return true; }, failure);
  for (const auto& entry : queue_.drop()) end(static_cast<ServerCall&>(*entry), failure);
  const auto open = open_;  // the remaining calls are sensor operations that are answered later
  for (const auto& call : open) {
    interrupt(*call);
    if (!call->state.ended()) end(*call, failure);
  }
}

void ObjectCalls::interrupt(ServerCall& call) {
  call.interrupt();
  interrupted_.notify_all();
}

void ObjectCalls::wait_interrupted(MutexLock<FutexMutex>& lock, const ServerCall& call,
                                   TimePoint deadline) {
  const auto wanted = [&] { return call.interrupted(); };
  if (deadline != TimePoint::max()) {
    interrupted_.wait_until(lock, deadline, wanted);
  } else {
    interrupted_.wait(lock, wanted);
  }
}

// The functions below are about deadlines and progress.

void ObjectCalls::list(ServerCall& call) {
  if (!std::exchange(call.listed, true)) open_.push_back(call.shared_from_this());
}

void ObjectCalls::on_tick(TimePoint now) {
  const auto open = open_;
  const TimePoint by_deadlines = open.empty() ? now : setup_.clock().since_boot();
  for (const auto& call : open) {
    if (!call->state.ended() && call->state.overdue(by_deadlines))
      end_overdue(*call, call->state.misses_start(by_deadlines));
    tell_progress(*call, now);
  }
  tell_positions(queue_);
  for (ServerCall* const running : handlers_.calls()) statistics_.runs_long(*running);
}

void ObjectCalls::end_overdue(ServerCall& call, bool missed_start) {
  if (call.state.begun_at()) {
    interrupt(call);
    end(call, Failure{Detail::TimedOut,
                      "the deadline of '" + std::string(call.operation().name) +
                          "' passed while the call was executing; its handler was told to stop: "
                          "allow the call more time",
                      {},
                      {}});
  } else {  // queued, or taken by a thread that will not begin its handler any more
    end(call, not_in_time(call.operation(), missed_start));
  }
  note_ready();
}

void ObjectCalls::progressed(ServerCall& call, double fraction, ByteView feedback) {
  if (call.state.ended()) return;
  call.reported.note(fraction, feedback);
  tell_progress(call, setup_.clock().now());
}

std::vector<std::shared_ptr<ServerCall>> ObjectCalls::held_up_by(const ServerCall& call) const {
  std::vector<std::shared_ptr<ServerCall>> holding;
  if (call.state.begun_at() || call.state.ended() || call.state.has_deadline()) return {};
  if (!call.state.queued()) {  // the servant begins its calls itself and has queued this call
    for (ServerCall* const handler : handlers_.calls()) {
      if (!setup_.servant.gecos_share_thread(handler->operation(), call.operation())) continue;
      holding.push_back(handler->shared_from_this());
    }
    return holding;
  }
  if (!setup_.options.thread_safe) {
    for (ServerCall* const handler : handlers_.calls()) {
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

}  // namespace gecos::session
