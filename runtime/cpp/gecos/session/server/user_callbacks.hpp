#pragma once

#include <functional>
#include <memory>
#include <string>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

class Maintenance;

/// Runs the callbacks of the user of one object, `on_stop` and `gecos_session_ended`. Logs what a
/// callback throws, because no caller can catch it. Thread-safe.
class UserCallbacks {
 public:
  UserCallbacks(Maintenance& maintenance, std::string object);
  ~UserCallbacks() { end(); }
  UserCallbacks(const UserCallbacks&) = delete;
  UserCallbacks& operator=(const UserCallbacks&) = delete;

  /// Runs `what` on this thread.
  void run(const std::function<void()>& what) const;
  /// Runs `what` on the maintenance thread, unless `end` is called before.
  void post(std::function<void()> what);
  /// Waits for the posted callback that runs. No posted callback starts after that. @pre not called
  /// from a posted callback
  void end();

 private:
  /// Outlives this object while callbacks are posted.
  struct Gate {
    Mutex mutex;
    bool ended GECOS_GUARDED_BY(mutex) = false;
  };

  Maintenance& maintenance_;
  const std::string object_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
};

}  // namespace gecos::session
