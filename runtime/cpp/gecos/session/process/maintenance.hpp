#pragma once

#include <poll.h>

#include <functional>
#include <memory>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/next_tick.hpp"
#include "gecos/session/process/pause_watch.hpp"

namespace gecos::session {

/// An object with periodic work: heartbeats, peer time-outs, timers.
class TickTarget {
 public:
  virtual ~TickTarget() = default;
  /// Called on the maintenance thread. Must not block and must not run a user's handler. Returns
  /// the time of the next tick (next_tick.hpp). The thread sleeps for at least `Maintenance::tick`,
  /// unless `wake`, `wake_requesters` or a watched descriptor wakes it.
  /// After `Maintenance::wake` the next tick of each target comes at once, whatever this function
  /// returned.
  virtual NextTick on_tick(TimePoint now) = 0;
  /// Returns whether this target asks for a tick at once, and clears the request. Called at each
  /// wake-up, before the ticks. A target must set its request before `wake_requesters` is called.
  virtual bool take_tick_request() { return false; }
  /// Called before `on_tick` when this process was suspended for the time `stood_still`. No call
  /// starts before this function has returned.
  virtual void after_pause(Duration stood_still) { static_cast<void>(stood_still); }
  /// Adds descriptors to `into`. An event on one of these descriptors wakes the maintenance thread
  /// before the next tick. The thread calls `unwatch` when it is awake again.
  virtual void watch(std::vector<pollfd>& into) { static_cast<void>(into); }
  virtual void unwatch() {}
};

/// The maintenance thread. No handler runs on this thread, so no handler can delay it. Without
/// targets the thread sleeps.
class Maintenance {
 public:
  static constexpr Duration tick = std::chrono::milliseconds(10);
  /// Time between two ticks of a target that has no work pending.
  static constexpr Duration calm_tick = std::chrono::milliseconds(25);

  explicit Maintenance(const Clock& clock);
  /// Ends the thread. Waits until the thread has ended, unless the caller is that thread.
  ~Maintenance();
  Maintenance(const Maintenance&) = delete;
  Maintenance& operator=(const Maintenance&) = delete;

  /// Calls `on_tick` of `target` until `target` is destroyed.
  void add(std::weak_ptr<TickTarget> target);
  /// Runs `job` once, soon, on the maintenance thread. `job` must not block.
  void post(std::function<void()> job);
  /// Makes the next tick of all targets due now.
  void wake();
  /// Gives a tick at once to the targets whose `take_tick_request` returns true. Costs less than
  /// `wake` in a process with a thousand targets.
  void wake_requesters();
  bool on_this_thread() const;
  /// Returns the object that detects from the ticks of this thread whether this process was
  /// suspended.
  PauseWatch& pauses();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::session
