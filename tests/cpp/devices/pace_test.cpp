// When the cycles of a device begin. Time is a number that the test passes in.
#include "devices/support/pace.hpp"

#include <gtest/gtest.h>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr gecos::TimePoint began_at{1h};
constexpr double simulated_cycle = 0.004;

TEST(Pace, InRealTimeMissedCyclesAreSkippedAndTheNextOneIsToldOfThem) {
  Pace pace(4ms, 1, began_at);
  EXPECT_EQ(pace.next(began_at).begins, began_at + 4ms);
  const Pace::Cycle late = pace.next(began_at + 4ms + 15ms);
  EXPECT_EQ(late.begins, began_at + 16ms);
  EXPECT_DOUBLE_EQ(late.seconds, 3 * simulated_cycle);
  EXPECT_EQ(pace.next(began_at + 19ms).begins, began_at + 20ms);
}

TEST(Pace, AtSpeedTenACycleLastsATenthAndItsSimulatedTimeIsTheSame) {
  Pace pace(4ms, 10, began_at);
  gecos::TimePoint now = began_at;
  for (int i = 1; i <= 1000; ++i) {
    const Pace::Cycle cycle = pace.next(now);
    ASSERT_EQ(cycle.begins, began_at + i * 400us);
    ASSERT_EQ(cycle.seconds, simulated_cycle);
    now = cycle.begins;
  }
  EXPECT_DOUBLE_EQ(pace.reached(), 10);
}

TEST(Pace, SlowerThanRealTimeACycleLastsLonger) {
  Pace pace(4ms, 0.1, began_at);
  const Pace::Cycle cycle = pace.next(began_at);
  EXPECT_EQ(cycle.begins, began_at + 40ms);
  EXPECT_EQ(cycle.seconds, simulated_cycle);
}

TEST(Pace, AtAnotherSpeedNoCycleIsSkippedAndAShortDelayIsCaughtUp) {
  Pace pace(4ms, 10, began_at);
  const gecos::TimePoint now = began_at + 4ms;
  for (int i = 1; i <= 12; ++i) {
    const Pace::Cycle cycle = pace.next(now);
    EXPECT_EQ(cycle.begins, began_at + i * 400us);
    EXPECT_EQ(cycle.seconds, simulated_cycle);
  }
}

TEST(Pace, ALongDelayIsNotCaughtUp) {
  Pace pace(4ms, 10, began_at);
  const gecos::TimePoint now = began_at + 10s;  // for example while the program was suspended
  EXPECT_EQ(pace.next(now).begins, now - Pace::most_behind);
  EXPECT_EQ(pace.next(now).begins, now - Pace::most_behind + 400us);
}

TEST(Pace, AMachineThatIsTooSlowReachesWhatItsCyclesTake) {
  Pace pace(4ms, 100'000, began_at);
  gecos::TimePoint now = began_at;
  for (int i = 0; i < 1000; ++i) {
    const Pace::Cycle cycle = pace.next(now);
    ASSERT_EQ(cycle.seconds, simulated_cycle);
    now = std::max(now, cycle.begins) + 1ms;
  }
  EXPECT_NEAR(pace.reached(), 4, 1e-3);
}

TEST(Pace, TheReachedSpeedIsThatOfTheLastTime) {
  Pace pace(4ms, 10, began_at);
  gecos::TimePoint now = began_at;
  const auto pass = [&](gecos::Duration time, gecos::Duration cycle_time) {
    for (const gecos::TimePoint end = now + time; now < end;) {
      now = std::max(pace.next(now).begins, now + cycle_time);
    }
  };
  pass(10 * Pace::window, 0ns);
  EXPECT_NEAR(pace.reached(), 10, 0.1);
  pass(10 * Pace::window, 2ms);
  EXPECT_NEAR(pace.reached(), 2, 0.1);
  pass(10 * Pace::window, 0ns);
  EXPECT_NEAR(pace.reached(), 10, 0.1);
}

}  // namespace
}  // namespace devices
