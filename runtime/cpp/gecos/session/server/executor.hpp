#pragma once

#include <deque>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// The threads of one object's handlers that take long. An idle one takes the next job, else a new
/// one is started, up to `most_threads`; none before the first job.
class Executor {
 public:
  /// More handlers than these wait for one of them to return.
  static constexpr std::size_t most_threads = 256;

  explicit Executor(std::string name) : name_(std::move(name)) {}
  ~Executor() { join(); }
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Runs it soon; false, and it is not run, after `join` began or when not one thread can be had.
  bool post(std::function<void()> job);
  /// Waits until all that was posted has run. @pre not on one of these threads.
  void join();

 private:
  void run();

  const std::string name_;
  Mutex mutex_;
  ConditionVariable work_;
  std::deque<std::function<void()>> jobs_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::thread> threads_ GECOS_GUARDED_BY(mutex_);
  std::size_t idle_ GECOS_GUARDED_BY(mutex_) = 0;
  /// The system gave none when one was asked for last.
  bool without_thread_ GECOS_GUARDED_BY(mutex_) = false;
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::session
