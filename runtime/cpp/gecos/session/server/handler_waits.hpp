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

/// Registers or forgets a session of a client, in any process, with an object of this process.
void note_session(SessionId id, std::weak_ptr<ObjectHost> object);
void forget_session(SessionId id);
/// The object to which `call` was issued; null when this process does not know its session.
std::shared_ptr<ObjectHost> object_in(const CommandId& call);

/// Describes how the waiting `handler` waits for its own end: "the handler of 'dim' of LAMP waits
/// for it …", or an empty string when that is not certain. Must be called without any object's
/// mutex held.
std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler);

}  // namespace gecos::session
