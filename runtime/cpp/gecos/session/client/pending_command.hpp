#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/short_bytes.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/session/client/seen_failures.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

class ClientConnection;

/// A call that was issued. Session and command keep each other alive until the command is terminal,
/// so a call still runs after the program has destroyed its Command. This class has more methods
/// and members than other classes, because it implements all of CommandCore and also holds the data
/// that its session needs to send the call again.
class PendingCommand final : public CommandCore {
 public:
  PendingCommand(std::shared_ptr<ClientConnection> session, const OperationDescription& operation)
      : operation_(operation.name),
        actor_(operation.status != access::Status::Sensor),
        keeps_place_(actor_ && !operation.safety && !is_builtin(operation.code)),
        home_(session.get()),
        session_(std::move(session)) {}
  /// Makes a command that ended before it was sent.
  explicit PendingCommand(Failure failure);
  /// Logs the failure of the command if the program has not observed it.
  ~PendingCommand() override;
  PendingCommand(const PendingCommand&) = delete;
  PendingCommand& operator=(const PendingCommand&) = delete;

  CommandId id() const override;
  Progress progress() const override;
  Bytes feedback() const override;
  bool wait_until(TimePoint deadline) override;
  void cancel() override;
  void ignore_outcome() override;
  ByteView result() const override { return result_.view(); }
  const Failure& failure() const override { return failure_; }
  void note_look(Detail seen) const override;
  int descriptor() override;
  void when_ended(std::function<void()> then) override;
  std::string about() const override;

  /// Returns true when the command is terminal. The load is sequentially consistent, because a
  /// follower calls this function right after it has registered with the LeaderLock; see
  /// LeaderLock::notify.
  bool terminal() const {
    return project(detail_.load(std::memory_order_seq_cst)) != State::Running;
  }

  /// Returns true for an actor command: the server takes the actor commands of a session in the
  /// order in which they were issued.
  bool keeps_place() const { return keeps_place_; }

  // Called by the session of the command.
  void report(Detail detail, const ProgressBody& body);
  void finish(ByteView result);
  void fail(Failure failure);
  // `counter`, `session_id` and `incarnation` are written before other threads know the command, or
  // by attach().
  std::uint64_t counter = 0;
  std::uint64_t session_id = 0;
  std::uint64_t incarnation = 0;
  /// The number of the call's packet on the connection. Written before other threads know the
  /// command.
  std::uint64_t sent_as = 0;
  /// Bit i is set if the shared word i may contain the mark of this call (start_words.hpp). Written
  /// before other threads know the command.
  std::uint8_t marked_words = 0;
  /// Notes that the command was sent in `session`, which is its first session or a later one. The
  /// caller must hold the mutex of the session's CallSender. `as`: the value for `sent_as`.
  void attach(const std::shared_ptr<ClientConnection>& session, const CommandId& id,
              std::uint64_t as);
  /// Notes that the session no longer has this command. The caller must hold the mutex of the
  /// session's CallSender, unless no session has the command.
  void detach() { home_.store(nullptr, std::memory_order_release); }

  /// Data of a command with @on_new("blend"), set before the command is shared. `failures` is told
  /// what the program knows of the end of the command.
  struct InChain {
    std::shared_ptr<SeenFailures> failures;
    SeenFailures::Place place{};
    /// If this command was not carried out because an earlier command failed, the counter of that
    /// earlier command; otherwise 0. Written before the command is terminal.
    std::uint64_t because_of = 0;
  } chain;

  /// True if the time at which the reply arrives must be recorded. Written before other threads
  /// know the command.
  bool timed = false;
  TimePoint answered{};  ///< time of the reply, if `timed`; written before the command is terminal

  /// State for sending the call again over a medium that loses packets. Guarded by the mutex of the
  /// session's CallSender.
  struct Retry {
    Bytes packet;
    TimePoint first{};  ///< when the packet was first sent
    TimePoint next{};
    TimePoint deadline = TimePoint::max();
    int sent = 1;
    bool on_its_way = false;  ///< the packet was sent at least once
    bool arrived = false;     ///< the server has the call; only the outcome is queried
    bool cancel = false;
    /// Counter of the last call that the session had issued when the program canceled this command.
    std::uint64_t cancel_up_to = 0;
  } retry;

  /// Data for sending the command again in another session. All members except the last three are
  /// set before the command is shared.
  struct Again {
    FunctionCode code{};
    std::string_view name;
    Bytes arguments;
    TimePoint deadline = TimePoint::max();
    /// Number of sessions in which the command was sent. Used only by the thread that sends the
    /// command.
    int sessions = 0;
    bool may_have_started = false;         ///< the command may have started in an earlier session
    std::condition_variable_any attached;  ///< notified when the command is attached or terminal
  };
  std::unique_ptr<Again> again;  ///< null: the command may not be sent again

 private:
  std::shared_ptr<ClientConnection> session() const;
  void watch_end() GECOS_REQUIRES(mutex_);
  std::string name_in(const ClientConnection& session) const;
  void log_end(const ClientConnection& in, Detail detail) const;
  bool awaits_failover() const {
    return again != nullptr && home_.load(std::memory_order_acquire) == nullptr;
  }
  bool wait_in_any_session(TimePoint deadline);
  void cancel_in_any_session();
  template <class Publish>
  void end(Detail detail, Publish publish);

  const std::string_view operation_;  ///< empty: the command was never sent
  const bool actor_ = false;          ///< the operation needs a status
  const bool keeps_place_ = false;
  /// True once `chain.failures` was told that the program has seen the failure of this command.
  mutable std::atomic<bool> looked_{false};
  mutable FutexMutex mutex_;
  std::atomic<Detail> detail_{Detail::Sent};  // a terminal value publishes result_, failure_
  std::uint32_t position_ GECOS_GUARDED_BY(mutex_) = 0;
  double fraction_ = 0;  ///< written with mutex_ held; constant once terminal
  Bytes feedback_ GECOS_GUARDED_BY(mutex_);
  ShortBytes result_;  ///< `result_` and `failure_` are written once, before detail_ is terminal
  Failure failure_;
  /// Name of the operation for the log, for example "RX90.move". Empty until the command fails
  /// before the program has asked for its result.
  std::string about_;
  /// True when the command is registered as a watcher of its session
  /// (ConnectionReader::add_watcher), because the program awaits the end of the command by a
  /// descriptor or a callback.
  bool watched_ GECOS_GUARDED_BY(mutex_) = false;
  std::unique_ptr<EventFd> exported_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::function<void()>> callbacks_ GECOS_GUARDED_BY(mutex_);
  /// The session that has the command; null while the command waits for failover. When the session
  /// changes, a thread that waits in the old session must continue its wait in the new session.
  std::atomic<const ClientConnection*> home_{nullptr};
  std::shared_ptr<ClientConnection> session_ GECOS_GUARDED_BY(mutex_);  ///< null once terminal
};

}  // namespace gecos::session
