#pragma once

#include <poll.h>

#include <functional>
#include <memory>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/session/process/pause_watch.hpp"

namespace gecos::session {

/// Something that needs a look now and then: heartbeats, silence, timers.
class Tended {
 public:
  virtual ~Tended() = default;
  /// On the housekeeping thread. Must not block and must not run a handler of a user. Gives when
  /// the next look is due; it may come sooner, and comes at the earliest after a
  /// `Housekeeping::tick`.
  virtual TimePoint tend(TimePoint now) = 0;
  /// Before that, where this process stood still for so long. Until it returns nothing starts.
  virtual void after_pause(Duration stood_still) { static_cast<void>(stood_still); }
  /// Adds descriptors to sleep on until the next look; `unwatch` follows after the sleep.
  virtual void watch(std::vector<pollfd>& into) { static_cast<void>(into); }
  virtual void unwatch() {}
};

/// The one thread that no handler can starve. Costs nothing while nobody is tended.
class Housekeeping {
 public:
  static constexpr Duration tick = std::chrono::milliseconds(10);
  /// Between looks at what has nothing on its way.
  static constexpr Duration calm_tick = std::chrono::milliseconds(25);

  explicit Housekeeping(const Clock& clock);
  /// Ends the thread and waits for it, unless it is this very thread.
  ~Housekeeping();
  Housekeeping(const Housekeeping&) = delete;
  Housekeeping& operator=(const Housekeeping&) = delete;

  /// Tends it from now on until it is gone.
  void tend(std::weak_ptr<Tended> tended);
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
