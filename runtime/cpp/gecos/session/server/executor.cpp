#include "gecos/session/server/executor.hpp"

#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/thread.hpp"

namespace gecos::session {

bool Executor::post(std::function<void()> job) {
  const MutexLock lock(mutex_);
  if (ended_) return false;
  jobs_.push_back(std::move(job));
  if (jobs_.size() > idle_ && threads_.size() < most_threads_) {
    try {
      threads_.push_back(start_thread(name_, [this] { run(); }));
      without_thread_ = false;
      return true;
    } catch (const std::system_error& failed) {
      if (!std::exchange(without_thread_, true)) {
        log_warning("session", name_ + ": no thread could be created for a handler (" +
                                   failed.what() +
                                   "); the handler waits until another handler returns");
      }
      if (threads_.empty()) {
        jobs_.pop_back();
        return false;
      }
    }
  }
  work_.notify_one();
  return true;
}

void Executor::run() {
  MutexLock lock(mutex_);
  for (;;) {
    ++idle_;
    while (!ended_ && jobs_.empty()) work_.wait(lock);
    --idle_;
    if (jobs_.empty()) return;
    auto job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    job = nullptr;
    lock.lock();
  }
}

void Executor::join() {
  std::vector<std::thread> threads;
  {
    const MutexLock lock(mutex_);
    ended_ = true;
    threads.swap(threads_);
  }
  work_.notify_all();
  for (auto& thread : threads) thread.join();
}

}  // namespace gecos::session
