#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/server.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/suspend_aware_clock.hpp"
#include "gecos/session/server/admission.hpp"
#include "gecos/session/server/executor.hpp"
#include "gecos/session/server/name_claim.hpp"
#include "gecos/session/server/object_queue.hpp"
#include "gecos/session/server/object_streams.hpp"
#include "gecos/session/server/outcome_log.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// The kind of thread that starts calls.
enum class Starter : std::uint8_t {
  Poller,  ///< runs short handlers itself
  Worker,  ///< a thread of the executor; runs short handlers itself
  Other,   ///< runs no handler: a user's thread, the maintenance thread, or a polling standby
};

/// One object of a server: admits and queues calls, keeps the leases, runs handlers and sends
/// replies. Every accepted call is answered exactly once, by its handler or by the event that ended
/// it.
class ObjectHost final : public Publisher, public std::enable_shared_from_this<ObjectHost> {
 public:
  ObjectHost(std::shared_ptr<Runtime> runtime, std::string name, Servant& servant,
             ObjectOptions options);

  const std::string& name() const { return name_; }
  const InterfaceDescription& interface() const { return interface_; }
  const ObjectOptions& options() const { return options_; }
  PeerLiveness::Bounds bounds_of_clients() const {
    return {.suspect_after = runtime_->options().lease_ttl,
            .dead_after = runtime_->registration_ttl()};
  }

  // Functions for the I/O loop (IoLoop).
  /// Processes one packet of `session`. Starts no call: call `run_ready` after it.
  void take(const std::shared_ptr<ServerSession>& session, ByteView packet);
  /// As `take`, but returns a call that may start now, or null. The caller must pass the call to
  /// `run_ready` soon.
  std::shared_ptr<ServerCall> take_and_start(const std::shared_ptr<ServerSession>& session,
                                             ByteView packet, Starter starter);
  /// Runs the handler of `started`, unless it is null, and the handlers of all calls that may
  /// start.
  void run_ready(Starter starter, std::shared_ptr<ServerCall> started = nullptr);
  /// A hint without locking the mutex: false when `run_ready` has nothing to do.
  bool ready() const { return ready_.load(std::memory_order_acquire); }

  // Any thread may call the functions below.
  /// How the connection of a session ended. After InOrder the commands of the session continue, and
  /// its status ends with the last of them.
  enum class Departure : std::uint8_t { InOrder, Lost };
  void depart(const std::shared_ptr<ServerSession>& session, Departure how);
  /// Must be called after this process was suspended: no call of `session` then starts before the
  /// next heartbeat of its client.
  void await_sign_of_life(ServerSession& session);
  /// Ends the actor commands that ran during a pause of length `stood_still`. After a long pause
  /// the broker must confirm the name again.
  void after_pause(Duration stood_still);
  /// Checks the heartbeats of `session`; called at every tick. Returns true when the session must
  /// end, because the client was silent for too long or does not read its replies.
  bool check_liveness(const std::shared_ptr<ServerSession>& session);
  /// Runs on the maintenance thread. Handles deadlines, leases and pending progress reports, and
  /// starts calls that no other thread starts. Returns when the next tick is due.
  TimePoint on_tick(TimePoint now);

  // Whether the broker confirms that this object has its name (name_claim.hpp).
  /// Must be called before the object is registered where other processes find it: from now on
  /// actor commands need the broker's confirmation of the name.
  void claim_name();
  std::uint64_t name_question();
  void name_held(std::uint64_t question);
  void name_provisional();
  void name_unanswered(std::uint64_t question, const std::string& why);
  /// Another server, `by`, has the name: ends the leases and stops the object.
  void name_taken(const std::string& by);

  /// Marks `call` as started. A servant that runs its handlers outside gecos_dispatch must call
  /// begin() directly before a handler begins. Returns false when the call has ended or may not
  /// start: then the handler must not begin.
  bool begin(ServerCall& call);
  void answered(ServerCall& call, ByteView result);
  void answered(ServerCall& call, Failure failure);
  void progressed(ServerCall& call, double fraction, ByteView feedback);
  /// Sleeps until `call` is interrupted or until `deadline`; returns true when it is interrupted.
  bool wait_interrupted(const ServerCall& call, TimePoint deadline);
  void publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) override;
  ObjectStreams& streams() { return streams_; }

  // What handlers wait for (handler_waits.hpp). Any thread may call these functions.
  /// Notes that the handler of `call` waits without a time-out for the call `awaited`. `name`
  /// describes `awaited`.
  void waits(ServerCall& call, const CommandId& awaited, std::string name);
  void goes_on(ServerCall& call);
  std::optional<CommandId> awaited_by(const ServerCall& call);
  /// The call with the id `call`; null when that call has not arrived or has ended.
  std::shared_ptr<ServerCall> find(const CommandId& call);
  /// The calls whose handlers must return before `call` can start; empty when `call` has started,
  /// has ended or has a deadline.
  std::vector<std::shared_ptr<ServerCall>> held_up_by(const ServerCall& call);

  /// Ends all calls as STOPPED and accepts no more.
  void close();
  bool closed();
  /// Waits until the handlers have returned. After that no other thread calls the servant or the
  /// user's callbacks. @pre closed, and not called from a handler
  void join();

 private:
  struct Acquire {
    Status wanted{};
    std::string password;
  };
  struct WaitingForStatus {
    std::shared_ptr<ServerSession> session;
    std::uint64_t counter = 0;
    Acquire what;
    TimePoint give_up{};
  };

  void look_at_time(TimePoint now);
  void end_endless_waits(TimePoint now);
  void refuse_endless(const CommandId& call, const std::string& why);
  std::vector<RunningHandler> running_handlers() GECOS_REQUIRES(mutex_);

  // Processing of packets.
  void take_packet(const std::shared_ptr<ServerSession>& session, ByteView bytes)
      GECOS_REQUIRES(mutex_);
  void acknowledge(const std::shared_ptr<ServerSession>& session, std::uint64_t counter)
      GECOS_REQUIRES(mutex_);
  void greet(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet)
      GECOS_REQUIRES(mutex_);
  void arrive(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet)
      GECOS_REQUIRES(mutex_);
  void refuse_late(ServerSession& session, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  void take_call(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet)
      GECOS_REQUIRES(mutex_);
  void admit(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
             const OperationDescription& operation) GECOS_REQUIRES(mutex_);
  void take_again(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet)
      GECOS_REQUIRES(mutex_);
  void resume(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet,
              std::shared_ptr<ServerCall> call) GECOS_REQUIRES(mutex_);
  void reject_late(const std::shared_ptr<ServerSession>& before, std::uint64_t counter)
      GECOS_REQUIRES(mutex_);
  bool too_early(ServerSession& session, const wire::PacketView& packet,
                 const OperationDescription& operation) GECOS_REQUIRES(mutex_);
  void take_early(const std::shared_ptr<ServerSession>& session) GECOS_REQUIRES(mutex_);
  void end_early(ServerSession& session, std::uint64_t counter, Detail how, const std::string& why)
      GECOS_REQUIRES(mutex_);
  void answer_again(ServerSession& session, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  void cancel(ServerSession& session, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  bool unheard_since_a_pause(const ServerSession& session) const GECOS_REQUIRES(mutex_);
  void withdraw(ServerSession& session) GECOS_REQUIRES(mutex_);
  void say_goodbye(ServerSession& session, SessionId to, const std::string& why)
      GECOS_REQUIRES(mutex_);

  // Built-in operations.
  void answer_builtin(const std::shared_ptr<ServerSession>& session, const wire::PacketView& packet)
      GECOS_REQUIRES(mutex_);
  void holders(ServerSession& session, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  void describe(ServerSession& session, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  void acquire(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
               ByteView arguments) GECOS_REQUIRES(mutex_);
  void grant(ServerSession& session, std::uint64_t counter, const Acquire& what)
      GECOS_REQUIRES(mutex_);
  /// Returns a command that has ended for its caller while its handler continues; null when there
  /// is no such command or a client holds a status. While it exists, no client may be granted a
  /// status.
  const ServerCall* outlives_its_status() const GECOS_REQUIRES(mutex_);
  void grant_to_waiting() GECOS_REQUIRES(mutex_);
  void refuse_waiting(TimePoint now) GECOS_REQUIRES(mutex_);
  bool waits_for_status(const ServerSession& session, std::uint64_t counter) const
      GECOS_REQUIRES(mutex_);
  void release(ServerSession& session, std::uint64_t counter, ByteView arguments)
      GECOS_REQUIRES(mutex_);
  void subscribe(ServerSession& session, std::uint64_t counter, ByteView arguments)
      GECOS_REQUIRES(mutex_);
  void unsubscribe(ServerSession& session, std::uint64_t counter, ByteView arguments)
      GECOS_REQUIRES(mutex_);
  void stop(ServerSession& by, std::uint64_t counter) GECOS_REQUIRES(mutex_);
  void outcome(ServerSession& session, std::uint64_t counter, ByteView arguments)
      GECOS_REQUIRES(mutex_);
  OutcomeRecord outcome_of(SessionId session, std::uint64_t counter) GECOS_REQUIRES(mutex_);

  // Start, interruption and end of calls.
  std::shared_ptr<ServerCall> start_next(Starter starter) GECOS_REQUIRES(mutex_);
  std::vector<std::shared_ptr<ServerCall>> actor_commands() const GECOS_REQUIRES(mutex_);
  std::shared_ptr<QueueEntry> next_entry() GECOS_REQUIRES(mutex_);
  /// True when a call of `operation` must not start because the name is not confirmed.
  bool needs_name(const OperationDescription& operation) const GECOS_REQUIRES(mutex_);
  void await_heartbeat(ServerSession& session) GECOS_REQUIRES(mutex_);
  void no_more_awaited(ServerSession& session) GECOS_REQUIRES(mutex_);
  bool may_start(ServerCall& call) GECOS_REQUIRES(mutex_);
  AdmittingObject as_asked() const GECOS_REQUIRES(mutex_) {
    return {name_, leases_, lease_clock_.now()};
  }
  TimePoint await_judgement() GECOS_REQUIRES(mutex_);
  bool marked(ServerCall& call, TimePoint now) GECOS_REQUIRES(mutex_);
  void not_begun(ServerCall& call);
  void never_began(ServerCall& call) GECOS_REQUIRES(mutex_);
  bool withdrawn(const ServerCall& call) GECOS_REQUIRES(mutex_);
  /// Ends `call` with `failure`, notifies its caller, and removes it from the queue if it has not
  /// started.
  void end(ServerCall& call, const Failure& failure) GECOS_REQUIRES(mutex_);
  void tell_outcome(ServerCall& call, const Failure& failure) GECOS_REQUIRES(mutex_);
  void tell_outcome(ServerCall& call, ByteView result) GECOS_REQUIRES(mutex_);
  void settle(ServerCall& call, Detail detail, const std::string& text) GECOS_REQUIRES(mutex_);
  void list(ServerCall& call) GECOS_REQUIRES(mutex_);
  void finished(ServerCall& call) GECOS_REQUIRES(mutex_);
  void preempt(const ServerCall& by) GECOS_REQUIRES(mutex_);
  /// Ends the actor commands that `which` selects: drops waiting ones, interrupts running ones.
  void end_commands(const std::function<bool(const ServerCall&)>& which, const Failure& failure)
      GECOS_REQUIRES(mutex_);
  void lose_status(SessionId session, const std::string& why) GECOS_REQUIRES(mutex_);
  void release_all(ServerSession& session) GECOS_REQUIRES(mutex_);
  void tell_positions() GECOS_REQUIRES(mutex_);
  void tell(ServerCall& call, TimePoint now) GECOS_REQUIRES(mutex_);
  void note_ready() { ready_.store(true, std::memory_order_release); }

  template <class Outcome>
  void take_answer(ServerCall& call, const Outcome& outcome);
  bool begins(ServerCall& call);
  /// Runs the handler of `call`. Returns the call that may start next, or null.
  std::shared_ptr<ServerCall> execute(const std::shared_ptr<ServerCall>& call, Starter starter);
  void interrupt(ServerCall& call) GECOS_REQUIRES(mutex_);
  void let_pause_be_judged(const ServerCall& call);
  /// Runs `what`, a callback of the user, on the maintenance thread. Drops it if the server has
  /// ended by then.
  void tell_user(std::function<void()> what);
  bool runs_long(const OperationDescription& operation) const {
    return operation.cancelable || options_.blocking;
  }

  const std::shared_ptr<Runtime> runtime_;
  const std::string name_;
  Servant& servant_;
  const InterfaceDescription& interface_;
  const ObjectOptions options_;

  FutexMutex mutex_;
  access::LeaseTable leases_ GECOS_GUARDED_BY(mutex_);
  NameClaim claim_ GECOS_GUARDED_BY(mutex_);
  ObjectQueue queue_ GECOS_GUARDED_BY(mutex_);
  OutcomeLog outcomes_ GECOS_GUARDED_BY(mutex_);
  std::condition_variable_any interrupted_;
  /// Calls that have a deadline or may take long.
  std::vector<std::shared_ptr<ServerCall>> open_ GECOS_GUARDED_BY(mutex_);
  /// The calls whose handlers have begun and have not finished, and how many of these handlers wait
  /// without a time-out.
  std::vector<ServerCall*> handlers_ GECOS_GUARDED_BY(mutex_);
  std::size_t waiting_handlers_ GECOS_GUARDED_BY(mutex_) = 0;
  SuspendAwareClock lease_clock_ GECOS_GUARDED_BY(mutex_);  ///< for leases and peer time-outs
  PauseWatch::Checked pause_ GECOS_GUARDED_BY(mutex_);      ///< the last check for a pause
  std::vector<WaitingForStatus> waiting_ GECOS_GUARDED_BY(mutex_);  ///< in order of request
  std::size_t awaited_ GECOS_GUARDED_BY(mutex_) = 0;  ///< sessions whose calls wait for a heartbeat
  bool closed_ GECOS_GUARDED_BY(mutex_) = false;
  std::atomic<bool> ready_{false};  // a hint: a call was queued or ended since the last check
  ObjectStreams streams_;

  Mutex user_mutex_;
  bool joined_ GECOS_GUARDED_BY(user_mutex_) = false;
  Executor executor_;  ///< last member, so that its threads end first
};

}  // namespace gecos::session
