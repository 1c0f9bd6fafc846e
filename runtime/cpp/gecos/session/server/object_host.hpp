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

/// Which thread asks for calls to be started.
enum class Starter : std::uint8_t {
  Poller,  ///< runs short handlers itself
  Worker,  ///< likewise
  Other,   ///< runs none: a thread of the user, maintenance, or a standby that polls
};

/// One object of a server: admits calls, keeps its leases, queues commands, runs handlers, answers.
/// Every call that was taken is answered exactly once, by its handler or by what ended it.
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

  // The poller.
  /// Takes one packet of `session`. Handlers that it makes ready run in `run_ready`.
  void take(const std::shared_ptr<ServerSession>& session, ByteView packet);
  /// Likewise, and starts what may start now: it is to be passed to `run_ready` soon.
  std::shared_ptr<ServerCall> take_and_start(const std::shared_ptr<ServerSession>& session,
                                             ByteView packet, Starter starter);
  /// Runs the handler of `started`, if it is one, and of all that may start.
  void run_ready(Starter starter, std::shared_ptr<ServerCall> started = nullptr);
  /// True when `run_ready` may have something to do; a hint that spares the lock.
  bool ready() const { return ready_.load(std::memory_order_acquire); }

  // Any thread.
  /// The link is gone. In order: its commands go on, its status drains.
  enum class Departure : std::uint8_t { InOrder, Lost };
  void depart(const std::shared_ptr<ServerSession>& session, Departure how);
  /// This process stood still: nothing of `session` starts before its next heartbeat.
  void await_sign_of_life(ServerSession& session);
  /// Ends the actor commands that ran meanwhile; after a long pause the name has to be confirmed.
  void after_pause(Duration stood_still);
  /// Heartbeat seen from it, or not, judged every tick. True: it ends, silent for so long or deaf.
  bool check_liveness(const std::shared_ptr<ServerSession>& session);
  /// Deadlines, leases, progress that waits to be told, and what may start and nobody looks at. On
  /// the maintenance thread. Gives when the next look is due.
  TimePoint on_tick(TimePoint now);

  // The name, as the broker answers for it (name_claim.hpp).
  /// It will be enlisted where others find it: from now on a broker has to confirm the name.
  void claim_name();
  std::uint64_t name_question();
  void name_held(std::uint64_t question);
  void name_provisional();
  void name_unanswered(std::uint64_t question, const std::string& why);
  /// Ends the leases and stops the object.
  void name_taken(const std::string& by);

  /// Directly before the handler of a call begins, where that is not in gecos_dispatch: marks it
  /// as started. False: it has ended meanwhile or may not start; drop it.
  bool begin(ServerCall& call);
  void answered(ServerCall& call, ByteView result);
  void answered(ServerCall& call, Failure failure);
  void progressed(ServerCall& call, double fraction, ByteView feedback);
  /// Sleeps until `call` is interrupted or `deadline`; true when it is.
  bool wait_interrupted(const ServerCall& call, TimePoint deadline);
  void publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) override;
  ObjectStreams& streams() { return streams_; }

  // What handlers wait for (handler_waits.hpp); any thread.
  /// The handler of `call` waits for another call, which is called `name`, without a bound.
  void waits(ServerCall& call, const CommandId& awaited, std::string name);
  void goes_on(ServerCall& call);
  std::optional<CommandId> awaited_by(const ServerCall& call);
  /// Null when it has not arrived, or has ended.
  std::shared_ptr<ServerCall> find(const CommandId& call);
  /// What has to return before `call` can start; nothing where it has, or ends by itself.
  std::vector<std::shared_ptr<ServerCall>> held_up_by(const ServerCall& call);

  /// Ends all calls as STOPPED and takes no more.
  void close();
  bool closed();
  /// Waits until the handlers have returned. From then on the servant and what else the user gave
  /// is called by no other thread. @pre closed, and not in one of them
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

  // Packets.
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
  /// A command that has ended for its caller, whose handler goes on; null unless nobody holds a
  /// status. Nobody gets one before it has returned.
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

  // Life of calls.
  std::shared_ptr<ServerCall> start_next(Starter starter) GECOS_REQUIRES(mutex_);
  std::vector<std::shared_ptr<ServerCall>> actor_commands() const GECOS_REQUIRES(mutex_);
  std::shared_ptr<QueueEntry> next_entry() GECOS_REQUIRES(mutex_);
  /// It must not start as the name stands.
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
  /// Tells its caller, and takes it out of the queue where it has not started.
  void end(ServerCall& call, const Failure& failure) GECOS_REQUIRES(mutex_);
  void tell_outcome(ServerCall& call, const Failure& failure) GECOS_REQUIRES(mutex_);
  void tell_outcome(ServerCall& call, ByteView result) GECOS_REQUIRES(mutex_);
  void settle(ServerCall& call, Detail detail, const std::string& text) GECOS_REQUIRES(mutex_);
  void list(ServerCall& call) GECOS_REQUIRES(mutex_);
  void finished(ServerCall& call) GECOS_REQUIRES(mutex_);
  void preempt(const ServerCall& by) GECOS_REQUIRES(mutex_);
  /// Ends those of the actor commands that `which` picks: drops the waiting, interrupts the
  /// running.
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
  /// Gives what may start after it.
  std::shared_ptr<ServerCall> execute(const std::shared_ptr<ServerCall>& call, Starter starter);
  void interrupt(ServerCall& call) GECOS_REQUIRES(mutex_);
  void let_pause_be_judged(const ServerCall& call);
  /// Runs what the user gave soon, on maintenance, unless the server has ended by then.
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
  /// Handlers that have begun and are not over; how many of them wait without a bound.
  std::vector<ServerCall*> handlers_ GECOS_GUARDED_BY(mutex_);
  std::size_t waiting_handlers_ GECOS_GUARDED_BY(mutex_) = 0;
  SuspendAwareClock lease_clock_ GECOS_GUARDED_BY(mutex_);  ///< leases and silence are judged by it
  PauseWatch::Checked pause_ GECOS_GUARDED_BY(mutex_);      ///< by whoever starts calls
  std::vector<WaitingForStatus> waiting_ GECOS_GUARDED_BY(mutex_);  ///< the first asked first
  std::size_t awaited_ GECOS_GUARDED_BY(mutex_) = 0;  ///< sessions whose calls wait for a heartbeat
  bool closed_ GECOS_GUARDED_BY(mutex_) = false;
  std::atomic<bool> ready_{
      false};  // a hint: something was queued or ended since it was last looked
  ObjectStreams streams_;

  Mutex user_mutex_;
  bool joined_ GECOS_GUARDED_BY(user_mutex_) = false;
  Executor executor_;  ///< last: its threads end first
};

}  // namespace gecos::session
