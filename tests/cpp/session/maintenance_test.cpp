#include "gecos/session/process/maintenance.hpp"

#include <gtest/gtest.h>

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <vector>

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

/// Simulates the ticks of targets for some time, and counts the wake-ups of their thread.
class Ticks {
 public:
  using Milliseconds = std::chrono::milliseconds;

  /// A target that ticks at `first` and then every 100 ms, and up to `early` earlier.
  struct Target : TickTimes {
    Duration early{};
  };
  void add(int first, int early) {
    Target& added = targets_.emplace_back();
    added.next = TimePoint{Milliseconds(first)};
    added.early = Milliseconds(early);
  }
  /// Returns in how many wake-ups the thread serves the targets from time `from` to `until`, in ms.
  int wake_ups(int from, int until) {
    int count = 0;
    while (now_ < TimePoint(Milliseconds(until))) {
      if (now_ >= TimePoint(Milliseconds(from))) ++count;
      now_ = tick_due(targets_, now_, false, [&](std::size_t at) {
        return NextTick(now_ + Milliseconds(100), targets_[at].early);
      });
    }
    return count;
  }

 private:
  std::vector<Target> targets_;
  TimePoint now_{};
};

TEST(TickDue, TicksThatMayComeEarlyComeTogetherWithOthersAfterAWhile) {
  for (int begin = 0; begin < 100; ++begin) {
    Ticks ticks;
    ticks.add(50, 0);
    ticks.add(begin, 20);
    EXPECT_LE(ticks.wake_ups(1000, 11'000), 101) << begin;
  }
}

TEST(TickDue, SeveralTargetsWhoseTicksMayComeEarlyMeet) {
  for (int begin = 0; begin < 100; ++begin) {
    Ticks ticks;
    ticks.add(50, 20);
    ticks.add(begin, 20);
    ticks.add(100 - begin, 20);
    EXPECT_LE(ticks.wake_ups(1000, 11'000), 101) << begin;
  }
}

TEST(TickDue, ATargetThatTicksAloneKeepsItsPeriod) {
  Ticks ticks;
  ticks.add(0, 20);
  EXPECT_EQ(ticks.wake_ups(0, 10'000), 100);
}

TEST(TickDue, TicksThatMayNotComeEarlyKeepTheirTimes) {
  Ticks ticks;
  ticks.add(0, 0);
  ticks.add(40, 0);
  EXPECT_EQ(ticks.wake_ups(0, 10'000), 200);
}

}  // namespace
}  // namespace gecos::session
