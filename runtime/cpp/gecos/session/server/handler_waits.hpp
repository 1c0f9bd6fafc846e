#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"

/// Deadlock detection between handlers of this process: handlers that wait for each other in a
/// cycle never return, so one of the awaited calls fails with the reason instead.
namespace gecos::session {

class ObjectHost;
class ServerCall;

/// note_session registers a client's session with an object of this process; forget_session removes
/// it. The client may be in any process.
void note_session(SessionId id, std::weak_ptr<ObjectHost> object);
void forget_session(SessionId id);
/// The object to which `call` was issued; null when this process does not know the session of
/// `call`.
std::shared_ptr<ObjectHost> object_in(const CommandId& call);

/// Returns a text that describes how `handler` waits, through other calls, for its own end: "the
/// handler of 'dim' of LAMP waits for it …". Returns an empty string when that is not certain. The
/// caller must not hold the mutex of any object.
std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler);

}  // namespace gecos::session
