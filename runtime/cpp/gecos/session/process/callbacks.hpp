#pragma once

#include <functional>
#include <memory>

namespace gecos::session {

/// Runs `callback` and logs any exception that it throws, because no caller can catch it.
void run_callback(const std::function<void()>& callback);

/// Runs the completion callbacks of commands one after another on its own thread. The thread starts
/// with the first callback. A callback may block; only the other callbacks then have to wait.
class Callbacks {
 public:
  Callbacks();
  /// Runs the remaining callbacks, then ends the thread. When a callback destroys this object, the
  /// thread first runs all remaining callbacks.
  ~Callbacks();
  Callbacks(const Callbacks&) = delete;
  Callbacks& operator=(const Callbacks&) = delete;

  void post(std::function<void()> callback);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::session
