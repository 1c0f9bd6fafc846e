#pragma once

#include <memory>

#include "gecos/binding.hpp"

/// Records which handler runs on which thread of this process, so that the object of a handler
/// learns for which call the handler waits without a time-out.
namespace gecos::session {

/// A call whose handler runs in this process.
class HandlerHere {
 public:
  virtual ~HandlerHere() = default;
  virtual std::shared_ptr<HandlerHere> shared() = 0;
  /// Notes that the thread of the handler waits for `command` without a time-out, until `goes_on`.
  virtual void waits(const CommandCore& command) = 0;
  virtual void goes_on() = 0;
};

/// Records, as long as it lives, that the handler of `call` runs on this thread.
class RunsHere {
 public:
  explicit RunsHere(HandlerHere& call);
  ~RunsHere();
  RunsHere(const RunsHere&) = delete;
  RunsHere& operator=(const RunsHere&) = delete;

 private:
  HandlerHere* const before_;
};

/// Records that the handler of `call` runs on this thread until it has answered.
void runs_here(std::weak_ptr<HandlerHere> call);

}  // namespace gecos::session
