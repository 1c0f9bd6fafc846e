#pragma once

#include <deque>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// A thread pool of one object, for example for its long handlers. An idle thread takes the next
/// job. When no thread is idle, the pool creates a thread, up to the maximum number that the
/// constructor gets. No thread exists before the first job.
class Executor {
 public:
  /// When `most_threads` are busy, further jobs wait until a job has returned.
  explicit Executor(std::string name, std::size_t most_threads = 256)
      : name_(std::move(name)), most_threads_(most_threads) {}
  ~Executor() { join(); }
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Queues `job` for a thread. Returns false, and does not run `job`, after `join` began or when
  /// the pool has no thread and cannot create one.
  bool post(std::function<void()> job);
  /// Waits until all posted jobs have run. @pre not called on a thread of this pool
  void join();

 private:
  void run();

  const std::string name_;
  const std::size_t most_threads_;
  Mutex mutex_;
  ConditionVariable work_;
  std::deque<std::function<void()>> jobs_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_ GECOS_GUARDED_BY(mutex_);
  std::size_t idle_ GECOS_GUARDED_BY(mutex_) = 0;
  /// True when the last attempt to create a thread failed.
  bool without_thread_ GECOS_GUARDED_BY(mutex_) = false;
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::session
