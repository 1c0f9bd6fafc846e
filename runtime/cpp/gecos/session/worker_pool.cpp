#include "gecos/session/worker_pool.hpp"

#include <utility>

#include "gecos/session/thread.hpp"

namespace gecos::session {

void WorkerPool::post(std::function<void()> job) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  jobs_.push_back(std::move(job));
  if (jobs_.size() > idle_) {
    threads_.push_back(start_thread(name_, [this] { run(); }));
  } else {
    work_.notify_one();
  }
}

void WorkerPool::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    ++idle_;
    work_.wait(lock, [this] { return ended_ || !jobs_.empty(); });
    --idle_;
    if (ended_) return;
    const auto job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
}

void WorkerPool::join() {
  std::vector<std::thread> threads;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    jobs_.clear();
    threads.swap(threads_);
  }
  work_.notify_all();
  for (auto& thread : threads) thread.join();
}

}  // namespace gecos::session
