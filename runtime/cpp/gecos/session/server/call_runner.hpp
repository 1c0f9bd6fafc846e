#pragma once

#include <memory>

#include "gecos/session/server/executor.hpp"
#include "gecos/session/server/host_state.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/start_gate.hpp"

namespace gecos::session {

/// Runs the handlers of one object and processes their answers. A handler runs on the thread that
/// polls or on a worker thread of the object. Thread-safe.
class CallRunner {
 public:
  explicit CallRunner(HostState& object);

  /// Runs the handler of `started`, unless `started` is null, and the handlers of all calls that
  /// may start.
  void run_ready(Starter starter, std::shared_ptr<ServerCall> started = nullptr);
  /// Waits until the handlers have returned. After that no thread of the object calls the servant.
  /// @pre the object is closed; the caller is not a handler
  void join() { executor_.join(); }

  // Handlers call the following functions.

  /// Marks `call` as started. A servant that runs its handlers outside gecos_dispatch must call
  /// begin() directly before a handler begins. Returns false when the call has ended or may not
  /// start. Then the handler must not begin.
  bool begin(ServerCall& call);
  void answered(ServerCall& call, ByteView result);
  void answered(ServerCall& call, Failure failure);
  void let_next(ServerCall& call);
  void progressed(ServerCall& call, double fraction, ByteView feedback);
  /// Sleeps until `call` is interrupted or until `deadline`; returns true when it is interrupted.
  bool wait_interrupted(const ServerCall& call, TimePoint deadline);

 private:
  bool begins(ServerCall& call);
  std::shared_ptr<ServerCall> execute(const std::shared_ptr<ServerCall>& call, Starter starter);
  void not_begun(ServerCall& call);
  TimePoint await_judgement() GECOS_REQUIRES(object_.mutex);
  void let_pause_be_judged(const ServerCall& call);
  template <class Outcome>
  void take_answer(ServerCall& call, const Outcome& outcome);

  HostState& object_;
  Executor executor_;
};

}  // namespace gecos::session
