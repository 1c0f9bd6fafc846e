#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"

/// Detects deadlocks between handlers of this process. Handlers that wait for each other in a cycle
/// never return, so one of the awaited calls is made to fail with the reason.
namespace gecos::session {

struct HostState;
class ObjectHost;
class ServerCall;

/// Records which calls the handlers of one object wait for. Thread-safe.
class HandlerWaits {
 public:
  explicit HandlerWaits(HostState& object) : object_(object) {}

  /// Notes that the handler of `call` waits without a time-out for the call `awaited`. `name`
  /// describes `awaited`.
  void waits(ServerCall& call, const CommandId& awaited, std::string name);
  void goes_on(ServerCall& call);
  std::optional<CommandId> awaited_by(const ServerCall& call);
  /// Returns the call with the id `call`; null when that call has not arrived or has ended.
  std::shared_ptr<ServerCall> find(const CommandId& call);
  /// Returns the calls whose handlers must return before `call` can start. Empty when `call` has
  /// started or has ended, or when `call` has a deadline, which ends the wait in any case.
  std::vector<std::shared_ptr<ServerCall>> held_up_by(const ServerCall& call);

  /// Finds the cycles of waits in which a handler of this object takes part, and ends one awaited
  /// call of each cycle.
  void end_endless(TimePoint now);

 private:
  void refuse(const CommandId& call, const std::string& why);

  HostState& object_;
};

/// `note_session` records a client's session with an object of this process; `forget_session`
/// removes the record. The client may be in any process.
void note_session(SessionId id, std::weak_ptr<ObjectHost> object);
void forget_session(SessionId id);
/// Returns the object to which `call` was issued; null when this process does not know the session
/// of `call`.
std::shared_ptr<ObjectHost> object_in(const CommandId& call);

/// Returns a text that describes how `handler` waits, directly or through other calls, for its own
/// end, for example "the handler of 'dim' of LAMP waits for this call …". In the text, "this call"
/// is the call for which `handler` waits. Returns an empty text when this is not certain. The
/// caller must not hold the mutex of any object.
std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler);

}  // namespace gecos::session
