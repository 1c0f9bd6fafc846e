#pragma once

#include <memory>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object.hpp"
#include "gecos/session/client/failover.hpp"

namespace gecos::session {

/// The part of one session in failover: sends `@idempotent` readings such that they can be sent
/// again in another session when this one is lost, and knows the session that was opened in its
/// place. Thread-safe, except `set`.
class SessionFailover {
 public:
  explicit SessionFailover(ClientConnection& session) : session_(session) {}

  /// Sets how another session with the object can be opened. Must be called before the session is
  /// shared. Without it, no call is sent again.
  void set(std::shared_ptr<Failover> failover, ConnectTarget target);
  /// @pre `set` was called
  const ConnectTarget& connect_target() const { return *connect_target_; }

  /// True when calls of `operation` may be sent again in another session.
  bool covers(const OperationDescription& operation) const {
    return failover_ != nullptr && operation.idempotent &&
           operation.status == access::Status::Sensor;
  }
  /// As ClientSession::call. @pre `covers(operation)`
  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                    FunctionRef<void(wire::Encoder&)> encode,
                                    const CallOptions& options);

  /// The session that was opened in place of this one, if that session still lives.
  std::shared_ptr<ClientConnection> successor();
  void set_successor(std::shared_ptr<ClientConnection> successor);
  /// Sends `command` in this session; returns false when the session has no room or is lost. @pre
  /// no other thread or session has `command`
  tl::expected<bool, Failure> send_again(const std::shared_ptr<PendingCommand>& command);

  /// Must be called when the server is UNREACHABLE: looks for another server for the open calls.
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
