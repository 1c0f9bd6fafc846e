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
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

class ClientConnection;

/// A call that was issued. The session and the command keep each other alive until the command is
/// terminal, so a command that its user drops still runs, and neither is kept afterwards.
class PendingCommand final : public CommandCore {
 public:
  PendingCommand(std::shared_ptr<ClientConnection> session, const OperationDescription& operation)
      : operation_(operation.name),
        actor_(operation.status != access::Status::Sensor),
        home_(session.get()),
        session_(std::move(session)) {}
  /// A command that ended before it was sent.
  explicit PendingCommand(Failure failure);
  /// Logs a failure that the program has not asked for.
  ~PendingCommand() override;
  PendingCommand(const PendingCommand&) = delete;
  PendingCommand& operator=(const PendingCommand&) = delete;

  CommandId id() const override;
  Progress progress() const override;
  Bytes feedback() const override;
  bool wait_until(TimePoint deadline) override;
  void cancel() override;
  ByteView result() const override { return result_.view(); }
  const Failure& failure() const override { return failure_; }
  int descriptor() override;
  void when_ended(std::function<void()> then) override;
  std::string about() const override;

  /// Sequentially consistent, because a follower checks it right after it has registered with the
  /// leader (LeaderLock::notify).
  bool terminal() const {
    return project(detail_.load(std::memory_order_seq_cst)) != State::Running;
  }

  // For its session.
  void report(Detail detail, const ProgressBody& body);
  void finish(ByteView result);
  void fail(Failure failure);
  std::uint64_t counter =
      0;  ///< written before the command is shared, as the two below, or by attach()
  std::uint64_t session_id = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t sent_as = 0;      ///< the packet's number on the link; written before it is shared
  std::uint8_t marked_words = 0;  ///< where the server marks its start; written before it is shared
  /// The command was sent in `session`, its first or another one. With that session's mutex held.
  void attach(const std::shared_ptr<ClientConnection>& session, const CommandId& id,
              std::uint64_t as);
  /// Its session no longer has the command. With that session's mutex held.
  void detach() { home_.store(nullptr, std::memory_order_release); }

  /// What a medium that loses packets needs; guarded by the session's mutex.
  struct Retry {
    Bytes packet;
    TimePoint first{};  ///< sent
    TimePoint next{};
    TimePoint deadline = TimePoint::max();
    int sent = 1;
    bool on_its_way = false;  ///< sent at least once
    bool arrived = false;     ///< the server has the call: only its outcome is queried
    bool cancel = false;
  } retry;

  /// Data for sending the command again in another session; set before it is shared, except the
  /// last three.
  struct Again {
    FunctionCode code{};
    std::string_view name;
    Bytes arguments;
    TimePoint deadline = TimePoint::max();
    int sessions = 0;  ///< number of sessions in which it was sent; used by its sender only
    bool may_have_started = false;         ///< in a session that no longer has it
    std::condition_variable_any attached;  ///< or terminal: ends a wait during failover
  };
  std::unique_ptr<Again> again;  ///< null: it may not be sent again

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

  const std::string_view operation_;  ///< empty: it was never sent
  const bool actor_ = false;          ///< it needs a status
  mutable FutexMutex mutex_;
  std::atomic<Detail> detail_{Detail::Sent};  // terminal: publishes result_ and failure_ to all
  std::uint32_t position_ GECOS_GUARDED_BY(mutex_) = 0;
  double fraction_ = 0;  ///< written with the mutex; constant once terminal
  Bytes feedback_ GECOS_GUARDED_BY(mutex_);
  ShortBytes result_;  ///< written once, before it is terminal, as failure_
  Failure failure_;
  std::string about_;  ///< "RX90.move"; written before it is terminal, unless observed
  /// Maintenance of session_ watches it, for a thread that sleeps elsewhere.
  bool watched_ GECOS_GUARDED_BY(mutex_) = false;
  std::unique_ptr<EventFd> exported_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::function<void()>> callbacks_ GECOS_GUARDED_BY(mutex_);
  /// The session that has the command; null while it waits for failover. Publishes nothing but
  /// itself: a thread that waits in that session must then wait elsewhere.
  std::atomic<const ClientConnection*> home_{nullptr};
  std::shared_ptr<ClientConnection> session_ GECOS_GUARDED_BY(mutex_);  ///< null once terminal
};

}  // namespace gecos::session
