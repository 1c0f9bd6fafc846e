#pragma once

#include <memory>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object.hpp"
#include "gecos/session/client/failover.hpp"

namespace gecos::session {

/// The part of one session that takes part in failover. Sends `@idempotent` readings in such a way
/// that another session can send them again when this session is lost. Knows the session that has
/// replaced this one. All functions but `set` are thread-safe.
class SessionFailover {
 public:
  explicit SessionFailover(ClientConnection& session) : session_(session) {}

  /// Sets how another session with the object can be opened. Must be called before other threads
  /// know the session. If it is not called, no call is sent again.
  void set(std::shared_ptr<Failover> failover, ConnectTarget target);
  /// @pre `set` was called
  const ConnectTarget& connect_target() const { return *connect_target_; }

  /// True when calls of `operation` may be sent again in another session.
  bool covers(const OperationDescription& operation) const {
    return failover_ != nullptr && operation.idempotent &&
           operation.status == access::Status::Sensor;
  }
  /// Like ClientSession::call. @pre `covers(operation)`
  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                    FunctionRef<void(wire::Encoder&)> encode,
                                    const CallOptions& options);

  /// Returns the session that has replaced this session and is not lost; null when there is none.
  std::shared_ptr<ClientConnection> successor();
  void set_successor(std::shared_ptr<ClientConnection> successor);
  /// Sends `command` in this session. Returns false when the session has no room for another call
  /// or is lost. @pre no other thread or session has `command`
  tl::expected<bool, Failure> send_again(const std::shared_ptr<PendingCommand>& command);

  /// Looks for another server for the open calls. Must be called when the server is UNREACHABLE.
  void look_for_another();
  /// Detaches all commands that may be sent again in another session.
  std::vector<PendingFailover> detach_repeatable();
  /// Sends `commands`, which were detached from this session, again in another session. @pre this
  /// session is lost
  void take_over(std::vector<PendingFailover> commands);

 private:
  std::shared_ptr<ClientConnection> next();
  tl::expected<void, media::SendProblem> send(const std::shared_ptr<PendingCommand>& command);

  ClientConnection& session_;
  std::shared_ptr<Failover> failover_;                   ///< null: no call is sent again
  std::unique_ptr<const ConnectTarget> connect_target_;  ///< set together with failover_
  FutexMutex mutex_;
  std::shared_ptr<ClientConnection> successor_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
