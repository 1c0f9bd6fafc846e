#pragma once

#include <memory>

#include "gecos/binding.hpp"

/// Which handler runs on which thread of this process, so that a call that it makes and waits for
/// without a bound can be told to its object.
namespace gecos::session {

/// A call of an object of this process whose handler runs.
class HandlerHere {
 public:
  virtual ~HandlerHere() = default;
  virtual std::shared_ptr<HandlerHere> shared() = 0;
  /// Its thread waits for `command` without a bound, until `goes_on`.
  virtual void waits(const CommandCore& command) = 0;
  virtual void goes_on() = 0;
};

/// While it lives, the handler of `call` runs on this thread.
class RunsHere {
 public:
  explicit RunsHere(HandlerHere& call);
  ~RunsHere();
  RunsHere(const RunsHere&) = delete;
  RunsHere& operator=(const RunsHere&) = delete;

 private:
  HandlerHere* const before_;
};

/// The handler of `call` runs on this thread until it has answered.
void runs_here(std::weak_ptr<HandlerHere> call);

}  // namespace gecos::session
