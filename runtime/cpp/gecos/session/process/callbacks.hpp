#pragma once

#include <functional>
#include <memory>

namespace gecos::session {

/// Runs `callback` and logs what it throws, because no caller waits for it.
void run_callback(const std::function<void()>& callback);

/// Runs the completion callbacks of commands one after another, on a thread of its own that starts
/// with the first callback. Callbacks may block; only other callbacks wait for them.
class Callbacks {
 public:
  Callbacks();
  /// Runs the callbacks that are left, then ends. When destroyed by a callback, the thread
  /// continues until none is left.
  ~Callbacks();
  Callbacks(const Callbacks&) = delete;
  Callbacks& operator=(const Callbacks&) = delete;

  void post(std::function<void()> callback);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::session
