// When the cycles of a device begin. Time is a number that the test passes in.
#include "devices/support/cycle_timer.hpp"

#include <gtest/gtest.h>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr gecos::TimePoint began_at{1h};
constexpr double simulated_cycle = 0.004;

TEST(CycleTimer, InRealTimeMissedCyclesAreSkippedAndTheNextOneIsToldOfThem) {
  CycleTimer timer(4ms, 1, began_at);
  EXPECT_EQ(timer.next(began_at).begins, began_at + 4ms);
  const CycleTimer::Cycle late = timer.next(began_at + 4ms + 15ms);
  EXPECT_EQ(late.begins, began_at + 16ms);
  EXPECT_DOUBLE_EQ(late.seconds, 3 * simulated_cycle);
  EXPECT_EQ(timer.next(began_at + 19ms).begins, began_at + 20ms);
}

TEST(CycleTimer, AtSpeedTenACycleLastsATenthAndItsSimulatedTimeIsTheSame) {
  CycleTimer timer(4ms, 10, began_at);
  gecos::TimePoint now = began_at;
  for (int i = 1; i <= 1000; ++i) {
    const CycleTimer::Cycle cycle = timer.next(now);
    ASSERT_EQ(cycle.begins, began_at + i * 400us);
    ASSERT_EQ(cycle.seconds, simulated_cycle);
    now = cycle.begins;
  }
  EXPECT_DOUBLE_EQ(timer.reached(), 10);
}

TEST(CycleTimer, SlowerThanRealTimeACycleLastsLonger) {
  CycleTimer timer(4ms, 0.1, began_at);
  const CycleTimer::Cycle cycle = timer.next(began_at);
  EXPECT_EQ(cycle.begins, began_at + 40ms);
  EXPECT_EQ(cycle.seconds, simulated_cycle);
}

TEST(CycleTimer, AtAnotherSpeedNoCycleIsSkippedAndAShortDelayIsCaughtUp) {
  CycleTimer timer(4ms, 10, began_at);
  const gecos::TimePoint now = began_at + 4ms;
  for (int i = 1; i <= 12; ++i) {
    const CycleTimer::Cycle cycle = timer.next(now);
    EXPECT_EQ(cycle.begins, began_at + i * 400us);
    EXPECT_EQ(cycle.seconds, simulated_cycle);
  }
}

TEST(CycleTimer, ALongDelayIsNotCaughtUp) {
  CycleTimer timer(4ms, 10, began_at);
  const gecos::TimePoint now = began_at + 10s;  // for example while the program was suspended
  EXPECT_EQ(timer.next(now).begins, now - CycleTimer::most_behind);
  EXPECT_EQ(timer.next(now).begins, now - CycleTimer::most_behind + 400us);
}

TEST(CycleTimer, AMachineThatIsTooSlowReachesWhatItsCyclesTake) {
  CycleTimer timer(4ms, 100'000, began_at);
  gecos::TimePoint now = began_at;
  for (int i = 0; i < 1000; ++i) {
    const CycleTimer::Cycle cycle = timer.next(now);
    ASSERT_EQ(cycle.seconds, simulated_cycle);
    now = std::max(now, cycle.begins) + 1ms;
  }
  EXPECT_NEAR(timer.reached(), 4, 1e-3);
}

TEST(CycleTimer, TheReachedSpeedIsThatOfTheLastTime) {
  CycleTimer timer(4ms, 10, began_at);
  gecos::TimePoint now = began_at;
  const auto pass = [&](gecos::Duration time, gecos::Duration cycle_time) {
    for (const gecos::TimePoint end = now + time; now < end;) {
      now = std::max(timer.next(now).begins, now + cycle_time);
    }
  };
  pass(10 * CycleTimer::window, 0ns);
  EXPECT_NEAR(timer.reached(), 10, 0.1);
  pass(10 * CycleTimer::window, 2ms);
  EXPECT_NEAR(timer.reached(), 2, 0.1);
  pass(10 * CycleTimer::window, 0ns);
  EXPECT_NEAR(timer.reached(), 10, 0.1);
}

}  // namespace
}  // namespace devices
