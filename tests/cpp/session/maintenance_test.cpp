#include "gecos/session/process/maintenance.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

// Its end meets its thread at every point of the thread's way to its first sleep.
TEST(Maintenance, EndsHoweverSoonAfterItsBeginning) {
  const Clock& clock = system_clock();
  for (int i = 0; i < 10'000; ++i) {
    const Maintenance brief(clock);
    for (int wait = i % 500; wait > 0; --wait) clock.now();
  }
}

/// Counts its ticks, and asks for the next one after `period`.
class CountedTarget final : public TickTarget {
 public:
  explicit CountedTarget(Duration period) : period_(period) {}
  NextTick on_tick(TimePoint now) override {
    const std::lock_guard lock(mutex_);
    ++ticks_;
    ticked_.notify_all();
    return now + period_;
  }
  bool take_tick_request() override { return requested_.exchange(false); }
  void request_tick() { requested_ = true; }
  void await_ticks(int count) {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(ticked_.wait_for(lock, std::chrono::seconds(30), [&] { return ticks_ >= count; }));
  }
  int ticks() {
    const std::lock_guard lock(mutex_);
    return ticks_;
  }

 private:
  const Duration period_;
  std::atomic<bool> requested_{false};
  std::mutex mutex_;
  std::condition_variable ticked_;
  int ticks_ = 0;
};

TEST(Maintenance, CallsATargetOnlyWhenItsTickIsDueOrTheThreadIsWoken) {
  Maintenance maintenance(system_clock());
  const auto often = std::make_shared<CountedTarget>(Maintenance::tick);
  const auto rarely = std::make_shared<CountedTarget>(std::chrono::hours(1));
  maintenance.add(rarely);
  maintenance.add(often);
  often->await_ticks(3);
  const int woken = rarely->ticks();  // add() wakes the thread, so that it may be more than one
  EXPECT_GE(woken, 1);
  often->await_ticks(often->ticks() + 5);
  EXPECT_EQ(rarely->ticks(), woken);
  maintenance.wake();
  rarely->await_ticks(woken + 1);
}

TEST(Maintenance, CallsOnlyTheTargetThatHasRequestedATick) {
  Maintenance maintenance(system_clock());
  const auto requester = std::make_shared<CountedTarget>(std::chrono::hours(1));
  const auto other = std::make_shared<CountedTarget>(std::chrono::hours(1));
  maintenance.add(requester);
  maintenance.add(other);  // the newer target ticks first
  requester->await_ticks(1);
  other->await_ticks(1);
  for (int time = 0; time < 5; ++time) {
    const int before = requester->ticks();
    const int others = other->ticks();
    requester->request_tick();
    maintenance.wake_requesters();
    requester->await_ticks(before + 1);
    // add() wakes the thread, at the latest with the first request.
    if (time > 0) {
      EXPECT_EQ(other->ticks(), others);
    }
  }
}

}  // namespace
}  // namespace gecos::session
