#pragma once

#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// Lets a standby thread sleep in wait() until another thread calls call(). Thread-safe.
class StandbyCall {
 public:
  /// Wakes the thread that waits, or lets its next wait() return at once.
  void call() {
    const MutexLock lock(mutex_);
    called_ = true;
    changed_.notify_one();
  }
  /// Ends the wait: from now on wait() returns false.
  void end() {
    const MutexLock lock(mutex_);
    ended_ = true;
    changed_.notify_one();
  }
  /// Sleeps until call() or end(). Returns false after end().
  bool wait() {
    MutexLock lock(mutex_);
    while (!called_ && !ended_) changed_.wait(lock);
    called_ = false;
    return !ended_;
  }

 private:
  Mutex mutex_;
  ConditionVariable changed_;
  bool called_ GECOS_GUARDED_BY(mutex_) = false;
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::session
