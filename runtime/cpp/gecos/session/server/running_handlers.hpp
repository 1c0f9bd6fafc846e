#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

namespace gecos::session {

class ServerCall;

/// The running handlers of one object, and the calls that these handlers wait for. Not thread-safe:
/// the object's mutex guards it.
class RunningHandlers {
 public:
  /// `add` must be called when the handler of `call` begins. `remove` must be called when that
  /// handler has answered and returned, or will not begin.
  void add(ServerCall& call);
  void remove(ServerCall& call);
  /// Returns the calls whose handlers run.
  const std::vector<ServerCall*>& calls() const { return calls_; }

  /// Notes that the handler of `call` waits without a time-out for the call `awaited`. `name`
  /// describes `awaited`.
  void waits(ServerCall& call, const CommandId& awaited, std::string name, TimePoint now);
  void goes_on(ServerCall& call);
  /// Returns the calls whose handlers have been waiting without a time-out at least since `before`.
  std::vector<std::shared_ptr<ServerCall>> waiting_since(TimePoint before) const;
  /// Returns the running handlers in the form in which the operation `describe` shows them.
  /// `since_boot`: the current time of Clock::since_boot.
  std::vector<RunningHandler> shown(TimePoint since_boot) const;

 private:
  std::vector<ServerCall*> calls_;
  std::size_t waiting_ = 0;  ///< how many of the handlers wait without a time-out
};

}  // namespace gecos::session
