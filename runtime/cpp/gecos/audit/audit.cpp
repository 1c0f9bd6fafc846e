#include "gecos/audit/audit.hpp"

#include <atomic>
#include <chrono>
#include <system_error>
#include <utility>
#include <vector>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/thread.hpp"

namespace gecos::audit {
namespace {

constexpr Duration longest_shutdown = std::chrono::seconds(1);

}  // namespace

struct Audit::Shared {
  explicit Shared(Journal its_journal) : journal(std::move(its_journal)) {}

  struct Batch {
    std::vector<Line> lines;
    std::uint64_t lost = 0;  ///< lines for which there was no room
  };
  Batch take();
  void run();
  void write(Batch batch);

  Journal journal;  ///< used by the thread only
  std::uint64_t unwritten =
      0;                 ///< lines that were lost and not yet counted; used by the thread only
  bool failing = false;  ///< the last write failed, which was logged; used by the thread only

  FutexMutex mutex;
  Batch waiting GECOS_GUARDED_BY(mutex);
  std::atomic<bool> any{false};  // a hint that `waiting` is not empty; orders no other memory
  std::atomic<std::uint32_t> rings{0};     // the thread sleeps until this number changes
  std::atomic<bool> shutting_down{false};  // orders no other memory

  Mutex end_mutex;
  ConditionVariable ended_changed;
  bool started GECOS_GUARDED_BY(end_mutex) = false;
  bool ended GECOS_GUARDED_BY(end_mutex) = false;
};

Audit::Shared::Batch Audit::Shared::take() {
  any.store(false, std::memory_order_relaxed);
  const MutexLock lock(mutex);
  return std::exchange(waiting, {});
}

void Audit::Shared::run() {
  for (;;) {
    const std::uint32_t seen = rings.load();
    const bool last = shutting_down.load();
    if (Batch batch = take(); !batch.lines.empty() || batch.lost != 0) {
      write(std::move(batch));
    } else if (last) {
      break;
    } else {
      rings.wait(seen);
    }
  }
  const MutexLock lock(end_mutex);
  ended = true;
  ended_changed.notify_all();
}

void Audit::Shared::write(Batch batch) {
  std::string text;
  unwritten += batch.lost;
  if (unwritten != 0) {
    text += to_json({.event = "lines_lost", .time = now(), .count = unwritten});
  }
  for (const Line& line : batch.lines) text += to_json(line);
  if (const auto appended = journal.append(text)) {
    unwritten = 0;
    failing = false;
    return;
  } else if (!std::exchange(failing, true)) {
    log_error("audit", "the audit is not written: " + appended.error() +
                           "; objects are served all the same, and the lost lines are counted; "
                           "set GECOS_AUDIT_DIR to use another folder");
  }
  unwritten += batch.lines.size();
}

Audit::Audit(Journal journal) : shared_(std::make_shared<Shared>(std::move(journal))) {}

void Audit::end() {
  flush();
  shared_->shutting_down.store(true);
  shared_->rings.fetch_add(1);
  shared_->rings.notify_all();
  MutexLock lock(shared_->end_mutex);
  if (!shared_->started) return;
  shared_->ended_changed.wait_until(lock, std::chrono::steady_clock::now() + longest_shutdown,
                                    [this] {
                                      shared_->end_mutex.assert_held();
                                      return shared_->ended;
                                    });
}

void Audit::add(Line line) {
  {
    const MutexLock lock(shared_->mutex);
    if (shared_->waiting.lines.size() < most_waiting) {
      shared_->waiting.lines.push_back(std::move(line));
    } else {
      ++shared_->waiting.lost;
    }
  }
  shared_->any.store(true, std::memory_order_relaxed);
}

void Audit::flush() {
  if (!shared_->any.load(std::memory_order_relaxed)) return;
  start();
  shared_->rings.fetch_add(1);
  shared_->rings.notify_one();
}

void Audit::start() {
  const MutexLock lock(shared_->end_mutex);
  if (shared_->started) return;
  try {
    start_thread("gecos-audit", [shared = shared_] { shared->run(); }).detach();
    shared_->started = true;
  } catch (const std::system_error&) {  // no thread is left; the next call tries again
  }
}

}  // namespace gecos::audit
