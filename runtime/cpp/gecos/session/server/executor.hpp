#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

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
  std::mutex mutex_;
  std::condition_variable work_;
  std::deque<std::function<void()>> jobs_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool without_thread_ = false;  ///< the system gave none when one was asked for last
  bool ended_ = false;
};

}  // namespace gecos::session
