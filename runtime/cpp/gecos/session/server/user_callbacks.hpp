#pragma once

#include <functional>
#include <memory>
#include <string>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

class Maintenance;

/// Runs the user's callbacks of one object: `on_stop` and `gecos_session_ended`. Logs an exception
/// that a callback throws, because no caller can catch it. Thread-safe.
class UserCallbacks {
 public:
  UserCallbacks(Maintenance& maintenance, std::string object);
  ~UserCallbacks() { end(); }
  UserCallbacks(const UserCallbacks&) = delete;
  UserCallbacks& operator=(const UserCallbacks&) = delete;

  /// Runs the callback `what` on the calling thread.
  void run(const std::function<void()>& what) const;
  /// Runs the callback `what` on the maintenance thread, unless `end` is called first.
  void post(std::function<void()> what);
  /// Waits until a posted callback that is running has returned. After that, no posted callback
  /// starts. @pre the caller is not a posted callback
  void end();

 private:
  /// The data that posted callbacks share. It outlives this object while posted callbacks wait.
  struct Gate {
    Mutex mutex;
    bool ended GECOS_GUARDED_BY(mutex) = false;
  };

  Maintenance& maintenance_;
  const std::string object_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
};

}  // namespace gecos::session
