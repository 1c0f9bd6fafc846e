#include "gecos/base/file_thread.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <string>
#include <utility>

#include "gecos/base/clock.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/thread.hpp"

namespace gecos {
namespace {

constexpr Duration longest_job_at_end = std::chrono::seconds(1);
/// `await` waits in steps of this length, so that a step that ends late shows a pause.
constexpr Duration step = std::chrono::milliseconds(25);

}  // namespace

/// The data that the thread uses. They outlive the FileThread if the job still runs when the
/// FileThread is destroyed.
struct FileThread::Shared {
  explicit Shared(std::function<void()> its_job) : job(std::move(its_job)) {}
  void work();
  void run_job() const;

  const std::function<void()> job;
  Mutex mutex;
  ConditionVariable changed;
  std::uint64_t asked GECOS_GUARDED_BY(mutex) = 0;      ///< number of the last run that is wanted
  std::uint64_t ended_run GECOS_GUARDED_BY(mutex) = 0;  ///< number of the last run that has ended
  /// Number of the run that is under way; without one, of the last run.
  std::uint64_t current_run GECOS_GUARDED_BY(mutex) = 0;
  TimePoint since GECOS_GUARDED_BY(mutex) = TimePoint::max();  ///< begin of the run; max: none runs
  bool must_end GECOS_GUARDED_BY(mutex) = false;
  bool ended GECOS_GUARDED_BY(mutex) = false;
};

void FileThread::Shared::work() {
  MutexLock lock(mutex);
  for (;;) {
    while (!must_end && asked == ended_run) changed.wait(lock);
    if (must_end) break;
    const std::uint64_t run = asked;
    current_run = run;
    since = SystemClock().now();
    lock.unlock();
    run_job();
    lock.lock();
    since = TimePoint::max();
    ended_run = run;
    changed.notify_all();
  }
  ended = true;
  changed.notify_all();
}

void FileThread::Shared::run_job() const {
  try {
    job();
  } catch (const std::exception& failed) {  // the next run tries again
    log_error("session", std::string("files were not read: ") + failed.what());
  }
}

FileThread::FileThread(const std::string& name, std::function<void()> job)
    : shared_(std::make_shared<Shared>(std::move(job))),
      thread_(start_thread(name, [shared = shared_] { shared->work(); })) {}

FileThread::~FileThread() {
  const TimePoint until = deadline_after(longest_job_at_end);
  MutexLock lock(shared_->mutex);
  shared_->must_end = true;
  shared_->changed.notify_all();
  while (!shared_->ended && shared_->changed.wait_until(lock, until)) {
  }
  const bool ended = shared_->ended;
  lock.unlock();
  if (ended) {
    thread_.join();
    return;
  }
  log_warning("session",
              "a file system does not answer; this program no longer waits for the file that it "
              "was reading");
  thread_.detach();
}

std::uint64_t FileThread::ask() {
  const MutexLock lock(shared_->mutex);
  shared_->changed.notify_all();
  return ++shared_->asked;
}

bool FileThread::await(std::uint64_t run, Duration patience) {
  const SystemClock clock;
  MutexLock lock(shared_->mutex);
  TimePoint now = clock.now();
  TimePoint until = now + patience;
  if (shared_->since != TimePoint::max() && shared_->current_run < run) {
    until = std::max(shared_->since + patience, now + std::min(step, patience));
  }
  while (shared_->ended_run < run && now < until) {
    const TimePoint wake = std::min(now + step, until);
    const bool notified = shared_->changed.wait_until(lock, wake);
    now = clock.now();
    if (notified) continue;
    // While this thread stood still, the thread of the job may have stood still, too.
    const Duration late = now - wake;
    until += late;
    if (late > step) until = std::max(until, now + step);
  }
  return shared_->ended_run >= run;
}

}  // namespace gecos
