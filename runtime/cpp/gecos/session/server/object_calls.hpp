#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/call_statistics.hpp"
#include "gecos/session/server/object_queue.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/outcome_log.hpp"
#include "gecos/session/server/running_handlers.hpp"
#include "gecos/session/server/server_call.hpp"

namespace gecos::session {

/// The calls of one object, from the queue until they have ended and their handlers have returned.
/// Sends each caller the outcome of its call exactly once, and keeps the outcomes of commands. Not
/// thread-safe: the object's mutex guards it. This class has more methods than other classes,
/// because it handles every way in which a call can end.
class ObjectCalls {
 public:
  /// The interface of an observer that is notified when calls end. The object's mutex is held
  /// during a notification. A notification may come while the observer itself is calling a function
  /// of this class, for example end_commands().
  class Observer {
   public:
    virtual ~Observer() = default;
    /// Called when no actor command of the session `client` is open any more.
    virtual void commands_ended(SessionId client) = 0;
    /// Called when `call` has ended and its handler has returned.
    virtual void finished(ServerCall& call) = 0;
  };

  /// `ready`: a flag that this object sets when a call may start that could not start before.
  ObjectCalls(const ObjectSetup& setup, std::atomic<bool>& ready, Observer& observer)
      : setup_(setup),
        ready_(ready),
        observer_(observer),
        queue_(setup.options.thread_safe ? LaneThreads::Many : LaneThreads::One),
        statistics_(setup.clock()) {}

  const ObjectQueue& queue() const { return queue_; }
  OutcomeLog& outcomes() { return outcomes_; }
  RunningHandlers& handlers() { return handlers_; }
  CallStatistics& statistics() { return statistics_; }
  /// True when no call is open and no handler runs.
  bool idle() const { return queue_.idle() && open_.empty(); }
  void note_ready() { ready_.store(true, std::memory_order_release); }

  // The following functions take a call from the queue to the end of its handler.

  /// Queues `added`. Returns the result of ObjectQueue::push.
  tl::expected<std::size_t, ObjectQueue::Full> add(std::shared_ptr<ServerCall> added);
  /// Removes the next call that may start from the queue and returns it; null when no call may
  /// start.
  std::shared_ptr<ServerCall> take();
  /// Like take(), but considers only the calls that `wanted` selects.
  std::shared_ptr<ServerCall> take(FunctionRef<bool(const ServerCall&)> wanted);
  /// Marks `call` as started. Must be called directly before the handler of the call begins. If the
  /// client has withdrawn the call, ends the call and returns false, because the client reports the
  /// call as not started.
  bool mark(ServerCall& call, TimePoint since_boot);
  /// Must be called when take() has returned `call`, but the handler of `call` will not begin. @pre
  /// the call has ended
  void drop(ServerCall& call);
  /// Records `outcome`, a result or a failure, as the answer of the handler of `call`. Returns true
  /// when the handler has also returned, so that the next call may start.
  template <class Outcome>
  bool answer(ServerCall& call, const Outcome& outcome) {
    const auto change = call.state.on(CallState::Event::Answer);
    if (change.report) tell_outcome(call, outcome);
    if (change.finished) finished(call);
    return change.finished;
  }
  /// Must be called when the handler of `call` has returned.
  void returned(const std::shared_ptr<ServerCall>& call);

  // The following functions end a call for a reason other than the answer of its handler.

  /// Ends `call` with `failure`, notifies its caller, and removes the call from the queue if the
  /// call has not started. @pre the call has not ended
  void end(ServerCall& call, const Failure& failure);
  /// Ends the actor commands that `which` selects: removes queued commands and interrupts running
  /// ones.
  void end_commands(FunctionRef<bool(const ServerCall&)> which, const Failure& failure);
  /// Ends all calls.
  void end_all(const Failure& failure);
  /// Sets the interrupt flag of `call` and wakes the threads that wait for this flag.
  void interrupt(ServerCall& call);
  /// Sleeps until `call` is interrupted or until `deadline`. `lock` holds the object's mutex.
  void wait_interrupted(MutexLock<FutexMutex>& lock, const ServerCall& call, TimePoint deadline);

  /// Adds `call` to the calls that on_tick() checks, because it has a deadline or may take long.
  void list(ServerCall& call);
  /// Ends calls whose deadline has passed. Sends the progress and queue positions that could not be
  /// sent before.
  void on_tick(TimePoint now);
  void progressed(ServerCall& call, double fraction, ByteView feedback);

  /// Returns the calls whose handlers must return before `call` can start; empty when `call` has
  /// started, has ended or has a deadline.
  std::vector<std::shared_ptr<ServerCall>> held_up_by(const ServerCall& call) const;

 private:
  void tell_outcome(ServerCall& call, const Failure& failure);
  void tell_outcome(ServerCall& call, ByteView result);
  void settle(ServerCall& call, Detail detail, const std::string& text);
  void break_chain(ServerCall& call, const Failure& failure);
  void finished(ServerCall& call);
  void end_overdue(ServerCall& call, bool missed_start);

  const ObjectSetup& setup_;
  std::atomic<bool>& ready_;
  Observer& observer_;
  ObjectQueue queue_;
  OutcomeLog outcomes_;
  RunningHandlers handlers_;
  CallStatistics statistics_;
  std::vector<std::shared_ptr<ServerCall>> open_;  ///< the calls that on_tick() checks, see list()
  std::condition_variable_any interrupted_;
};

}  // namespace gecos::session
