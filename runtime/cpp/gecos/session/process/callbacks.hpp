#pragma once

#include <functional>
#include <memory>

namespace gecos::session {

/// Runs it. What it throws is logged, as nobody waits for it that could be told.
void run_callback(const std::function<void()>& callback);

/// Runs what users hung on the ends of their commands: one after another, on a thread of its own
/// that starts with the first. They may block; only other callbacks wait for them.
class Callbacks {
 public:
  Callbacks();
  /// Runs what is left, then ends. From a callback: its thread goes on until nothing is left.
  ~Callbacks();
  Callbacks(const Callbacks&) = delete;
  Callbacks& operator=(const Callbacks&) = delete;

  void post(std::function<void()> callback);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::session
