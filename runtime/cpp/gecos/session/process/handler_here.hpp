#pragma once

#include <memory>

#include "gecos/binding.hpp"

/// Records which handler runs on which thread of this process. When a handler waits for another
/// call without a time-out, the object of the handler is told which call the handler
/// waits for.
namespace gecos::session {

/// A call whose handler runs in this process.
class HandlerHere {
 public:
  virtual ~HandlerHere() = default;
  virtual std::shared_ptr<HandlerHere> shared() = 0;
  /// Notes that the thread of the handler waits for `command` without a time-out, until `goes_on`
  /// is called.
  virtual void waits(const CommandCore& command) = 0;
  virtual void goes_on() = 0;
};

/// While this object lives, records that the handler of `call` runs on the current thread.
class RunsHere {
 public:
  explicit RunsHere(HandlerHere& call);
  ~RunsHere();
  RunsHere(const RunsHere&) = delete;
  RunsHere& operator=(const RunsHere&) = delete;

 private:
  HandlerHere* const before_;
};

/// Records that the current thread runs the handler of `call`, until the call is answered.
void runs_here(std::weak_ptr<HandlerHere> call);

}  // namespace gecos::session
