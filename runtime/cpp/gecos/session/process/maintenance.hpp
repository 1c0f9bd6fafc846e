#pragma once

#include <poll.h>

#include <functional>
#include <memory>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/pause_watch.hpp"

namespace gecos::session {

/// Something that needs a look now and then: heartbeats, silence, timers.
class TickTarget {
 public:
  virtual ~TickTarget() = default;
  /// On the maintenance thread. Must not block and must not run a handler of a user. Gives when
  /// the next look is due; it may come sooner, and comes at the earliest after a
  /// `Maintenance::tick`.
  virtual TimePoint on_tick(TimePoint now) = 0;
  /// Before that, where this process stood still for so long. Until it returns nothing starts.
  virtual void after_pause(Duration stood_still) { static_cast<void>(stood_still); }
  /// Adds descriptors to sleep on until the next look; `unwatch` follows after the sleep.
  virtual void watch(std::vector<pollfd>& into) { static_cast<void>(into); }
  virtual void unwatch() {}
};

/// The one thread that no handler can starve. Costs nothing without targets.
class Maintenance {
 public:
  static constexpr Duration tick = std::chrono::milliseconds(10);
  /// Between looks at what has nothing on its way.
  static constexpr Duration calm_tick = std::chrono::milliseconds(25);

  explicit Maintenance(const Clock& clock);
  /// Ends the thread and waits for it, unless it is this very thread.
  ~Maintenance();
  Maintenance(const Maintenance&) = delete;
  Maintenance& operator=(const Maintenance&) = delete;

  /// Calls its `on_tick` until it is gone.
  void add(std::weak_ptr<TickTarget> target);
  /// Runs it once, soon. Must not block.
  void post(std::function<void()> job);
  /// Looks again now.
  void wake();
  bool on_this_thread() const;
  /// Whether this process stood still, as this thread's ticks tell.
  PauseWatch& pauses();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::session
