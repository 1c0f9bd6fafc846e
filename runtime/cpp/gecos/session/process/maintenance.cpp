#include "gecos/session/process/maintenance.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/suspension.hpp"
#include "gecos/base/thread.hpp"

namespace gecos::session {
/// The state shared with the maintenance thread. It outlives the Maintenance object when that
/// object is destroyed on the maintenance thread.
struct Maintenance::Shared {
  explicit Shared(const Clock& its_clock) : clock(its_clock) {}

  struct Target : TickTimes {
    explicit Target(std::weak_ptr<TickTarget> its_target) : target(std::move(its_target)) {}
    std::weak_ptr<TickTarget> target;
  };

  void run();
  std::vector<std::function<void()>> take_jobs();
  std::vector<std::shared_ptr<TickTarget>> look_at();
  bool judge_pause(const std::vector<std::shared_ptr<TickTarget>>& alive);
  enum class Which : std::uint8_t { All, Due };
  void tick_targets(const std::vector<std::shared_ptr<TickTarget>>& alive, Which which);

  const Clock& clock;
  PauseWatch pauses;
  const pid_t owner = getpid();
  EventFd event;
  std::thread thread;
  std::atomic<bool> ended{false};    // asks the thread to end; orders no other memory
  std::atomic<bool> all_due{false};  // wake() was called; orders no other memory
  std::vector<Target> targets;       // used by the thread only
  Mutex mutex;
  std::vector<std::weak_ptr<TickTarget>> added GECOS_GUARDED_BY(mutex);
  std::vector<std::function<void()>> jobs GECOS_GUARDED_BY(mutex);
};

std::vector<std::function<void()>> Maintenance::Shared::take_jobs() {
  const MutexLock lock(mutex);
  return std::exchange(jobs, {});
}

/// Returns the targets that still exist, in the order of `targets`. Removes all other targets from
/// `targets`.
std::vector<std::shared_ptr<TickTarget>> Maintenance::Shared::look_at() {
  {
    const MutexLock lock(mutex);
    for (auto& one : added) targets.emplace_back(std::move(one));
    added.clear();
  }
  std::vector<std::shared_ptr<TickTarget>> alive;
  std::erase_if(targets, [&](const Target& one) {
    auto exists = one.target.lock();
    if (exists == nullptr) return true;
    alive.push_back(std::move(exists));
    return false;
  });
  return alive;
}

/// If this process was suspended, logs this, tells all targets in `alive`, and returns true.
/// Otherwise returns false.
bool Maintenance::Shared::judge_pause(const std::vector<std::shared_ptr<TickTarget>>& alive) {
  const TimePoint now = clock.since_boot();
  const auto stood_still = pauses.tick(now);
  if (!stood_still) return false;
  log_warning("session", "this process " + stood_still_for(*stood_still));
  for (const auto& one : alive) one->after_pause(*stood_still);
  pauses.judged(clock.since_boot() + tick);
  return true;
}

/// Calls all targets, or only those that have asked for a tick or whose ticks are due.
void Maintenance::Shared::tick_targets(const std::vector<std::shared_ptr<TickTarget>>& alive,
                                       Which which) {
  const TimePoint now = clock.now();
  const auto tick_one = [&](std::size_t at) { return alive[at]->on_tick(now); };
  for (std::size_t at = 0; at < alive.size(); ++at) {
    if (alive[at]->take_tick_request()) targets[at].next = now;
  }
  if (which == Which::All) {
    tick_all(targets, tick_one);
  } else {
    tick_due(targets, now, tick_one);
  }
}

void Maintenance::Shared::run() {
  std::vector<pollfd> descriptors;
  bool descriptor_ready = false;
  for (;;) {
    // Drains the event before the checks, so that a notification that arrives during the checks is
    // not lost.
    event.drain();
    const bool woken = all_due.exchange(false) || descriptor_ready;
    if (ended.load()) return;
    for (const auto& job : take_jobs()) job();
    auto alive = look_at();
    note_suspension(clock);
    const bool paused = judge_pause(alive);
    tick_targets(alive, woken || paused ? Which::All : Which::Due);
    descriptor_ready = false;
    const TimePoint next = wake_at(targets);

    const bool idle = next == TimePoint::max();
    const auto rest =
        std::chrono::ceil<std::chrono::milliseconds>(std::max(next - clock.now(), tick));
    const TimePoint looked = clock.since_boot();
    if (!pauses.due(idle ? TimePoint::max() : looked + rest, looked)) continue;

    descriptors.assign(1, {event.descriptor(), POLLIN, 0});
    for (const auto& one : alive) one->watch(descriptors);
    std::vector<std::weak_ptr<TickTarget>> watched(alive.begin(), alive.end());
    // These references are dropped before the sleep, so that a target is destroyed at once when its
    // other owners drop it during the sleep.
    alive.clear();
    const int ready =
        poll(descriptors.data(), descriptors.size(), idle ? -1 : static_cast<int>(rest.count()));
    descriptor_ready = ready > (descriptors.front().revents != 0 ? 1 : 0);
    for (const auto& one : watched) {
      if (const auto still = one.lock()) still->unwatch();
    }
  }
}

Maintenance::Maintenance(const Clock& clock) : shared_(std::make_shared<Shared>(clock)) {
  shared_->thread = start_thread("gecos-maint", [shared = shared_] { shared->run(); });
}

Maintenance::~Maintenance() {
  shared_->ended = true;
  shared_->event.notify();
  if (on_this_thread() || getpid() != shared_->owner) {  // the thread is absent in a forked child
    shared_->thread.detach();
  } else {
    shared_->thread.join();
  }
}

void Maintenance::add(std::weak_ptr<TickTarget> target) {
  {
    const MutexLock lock(shared_->mutex);
    shared_->added.push_back(std::move(target));
  }
  wake();
}

void Maintenance::post(std::function<void()> job) {
  {
    const MutexLock lock(shared_->mutex);
    shared_->jobs.push_back(std::move(job));
  }
  wake();
}

void Maintenance::wake() {
  shared_->all_due = true;
  shared_->event.notify();
}

void Maintenance::wake_requesters() { shared_->event.notify(); }

PauseWatch& Maintenance::pauses() { return shared_->pauses; }

bool Maintenance::on_this_thread() const {
  return std::this_thread::get_id() == shared_->thread.get_id();
}

}  // namespace gecos::session
