#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/session/command.hpp"

/// Which handler runs on which thread of this process, and which call it waits for: where handlers
/// wait for each other in a circle, none of them returns, and that is told instead.
namespace gecos::session {

class ServedObject;
class ServerCall;

/// While it lives, the handler of `call` runs on this thread.
class RunsHere {
 public:
  explicit RunsHere(ServerCall& call);
  ~RunsHere();
  RunsHere(const RunsHere&) = delete;
  RunsHere& operator=(const RunsHere&) = delete;

 private:
  ServerCall* const before_;
};

/// The handler of `call` runs on this thread until it has answered.
void runs_here(std::weak_ptr<ServerCall> call);

/// While it lives, the handler that runs on this thread, if one does, waits for `command` without a
/// bound.
class WaitsHere {
 public:
  explicit WaitsHere(const CommandCore& command);
  ~WaitsHere();
  WaitsHere(const WaitsHere&) = delete;
  WaitsHere& operator=(const WaitsHere&) = delete;

 private:
  std::shared_ptr<ServerCall> handler_;
};

/// Sessions of clients of any process with objects of this one.
void note_session(SessionId id, std::weak_ptr<ServedObject> object);
void forget_session(SessionId id);
/// The object of that session; null when it is none of this process.
std::shared_ptr<ServedObject> object_in(const CommandId& call);

/// How `handler`, which waits, waits for its own end: "the handler of 'dim' of LAMP waits for it
/// …", or nothing when it is not certain that it does. No object's mutex may be held.
std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler);

}  // namespace gecos::session
