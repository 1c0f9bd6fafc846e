#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"

/// Which call a handler of this process waits for: where handlers wait for each other in a circle,
/// none of them returns, and that is told instead.
namespace gecos::session {

class ObjectHost;
class ServerCall;

/// Sessions of clients of any process with objects of this one.
void note_session(SessionId id, std::weak_ptr<ObjectHost> object);
void forget_session(SessionId id);
/// The object of that session; null when it is none of this process.
std::shared_ptr<ObjectHost> object_in(const CommandId& call);

/// How `handler`, which waits, waits for its own end: "the handler of 'dim' of LAMP waits for it
/// …", or nothing when it is not certain that it does. No object's mutex may be held.
std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler);

}  // namespace gecos::session
