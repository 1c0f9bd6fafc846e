#include "gecos/media/waiting.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>

#include <array>
#include <atomic>
#include <vector>

#include "gecos/media/bell.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

/// A clock on which every reading takes `step`: what one look and one yield cost.
class SteppingClock final : public Clock {
 public:
  TimePoint now() const override {
    at_ += step;
    ++readings;
    return at_;
  }
  double unix_seconds() const override { return 0; }
  Duration step = 100ns;
  mutable int readings = 0;

 private:
  mutable TimePoint at_{1h};
};

int looks_of_one_wait(SpinPolicy& spin) {
  int looks = 0;
  spin.begin();
  while (spin.again()) ++looks;
  return looks;
}

/// It has given its core away, and every reading of the clock takes a microsecond.
class BesideABusyProgram : public ::testing::Test {
 protected:
  BesideABusyProgram() {
    clock_.step = 300us;
    looks_of_one_wait(spin_);
    clock_.step = 1us;
  }
  SteppingClock clock_;
  SpinPolicy spin_{clock_, {.longest = 10us, .vain_in_row = 3, .looks_alone = 7}};
};

TEST(SpinPolicy, SpinsForItsBudgetThenSleeps) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.longest = 10us, .looks_alone = 0});
  // 100 yields of 100 ns fill 10 µs, and after the last of them there is no look.
  EXPECT_EQ(looks_of_one_wait(spin), 99);
  EXPECT_FALSE(spin.again()) << "a wait that is over must not spin again";
}

TEST(SpinPolicy, LooksManyTimesBetweenYieldsOnACoreOfItsOwn) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.longest = 10us, .looks_alone = 7});
  // A round is eight looks, and two readings of the clock around its yield. Time counts from the
  // first.
  EXPECT_EQ(looks_of_one_wait(spin), 51 * 8);
}

TEST(SpinPolicy, SlowYieldsToNobodyAreNotTakenForSomebody) {
  SteppingClock clock;
  clock.step = 900ns;  // what they take in some virtual machines
  SpinPolicy spin(clock, {.longest = 18us, .looks_alone = 7});
  EXPECT_EQ(looks_of_one_wait(spin), 11 * 8);
}

TEST(SpinPolicy, LearnsWhatAYieldToNobodyTakesHere) {
  SteppingClock clock;
  clock.step = 200ns;
  SpinPolicy spin(clock, {.longest = 8us, .looks_alone = 7});
  EXPECT_EQ(looks_of_one_wait(spin), 21 * 8);
  clock.step = 400ns;  // now twice as long: somebody else runs
  EXPECT_EQ(looks_of_one_wait(spin), 8 + 19);
}

TEST(SpinPolicy, YieldsAfterEveryLookWhereSomebodyElseRuns) {
  SteppingClock clock;
  clock.step = 2us;
  SpinPolicy spin(clock, {.longest = 100us, .looks_alone = 7});
  // The first round of 7 looks still hopes for a core of its own.
  EXPECT_EQ(looks_of_one_wait(spin), 8 + 49);
}

TEST(SpinPolicy, ALostCoreStopsYieldsForAWhileThatDoubles) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.looks_alone = 0});
  Duration expected = 20ms;
  for (int time = 0; time < 8; ++time) {
    clock.step = 300us;
    EXPECT_LE(looks_of_one_wait(spin), 1);
    const TimePoint now = clock.now() - clock.step;
    EXPECT_EQ(spin.crowded_until() - now, expected);
    expected = std::min<Duration>(2 * expected, 1s);

    clock.step = spin.crowded_until() - now;
    clock.now();
  }
}

TEST_F(BesideABusyProgram, ItLooksForItsBudgetAndDoesNotYield) {
  const int before = clock_.readings;
  // Eight looks, then the clock is read once; a yield would be timed by a second reading.
  EXPECT_EQ(looks_of_one_wait(spin_), 10 * 8);
  EXPECT_EQ(clock_.readings - before, 11);
}

TEST_F(BesideABusyProgram, LooksThatAreAlwaysInVainAreGivenUpUntilYieldsAreTriedAgain) {
  for (int wait = 0; wait < 3; ++wait) {
    EXPECT_FALSE(spin_.in_vain());
    EXPECT_GT(looks_of_one_wait(spin_), 0);
  }
  EXPECT_TRUE(spin_.in_vain());
  EXPECT_EQ(looks_of_one_wait(spin_), 0);
  clock_.step = 20ms;
  clock_.now();
  clock_.step = 100ns;
  EXPECT_GT(looks_of_one_wait(spin_), 0);
  EXPECT_FALSE(spin_.in_vain());
}

TEST_F(BesideABusyProgram, WhatComesWhileItLooksIsWhyItGoesOnLooking) {
  for (int wait = 0; wait < 30; ++wait) {
    if (wait % 3 != 0) {
      EXPECT_GT(looks_of_one_wait(spin_), 0);
      continue;
    }
    spin_.begin();
    EXPECT_TRUE(spin_.again());  // and then it came
  }
  EXPECT_FALSE(spin_.in_vain());
}

TEST(SpinPolicy, AQuietSpinForgetsTheLostCores) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.looks_alone = 0});
  clock.step = 300us;
  looks_of_one_wait(spin);
  clock.step = 1s;
  clock.now();
  clock.step = 100ns;
  EXPECT_GT(looks_of_one_wait(spin), 1);
  clock.step = 300us;
  looks_of_one_wait(spin);
  EXPECT_EQ(spin.crowded_until() - (clock.now() - clock.step), 20ms);
}

TEST(SpinPolicy, WhereTheCoreIsSharedAWaitOfOneYieldReadsTheClockOnce) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.looks_alone = 0});
  constexpr int waits = 640;
  for (int wait = 0; wait < waits; ++wait) {
    spin.begin();
    EXPECT_TRUE(spin.again());
  }
  EXPECT_GE(clock.readings, waits);
  EXPECT_LE(clock.readings, waits + waits / 64 + 1) << "now and then a yield is timed by itself";
}

TEST(SpinPolicy, ALongTimeBetweenTwoWaitsIsNoLostCore) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.looks_alone = 0});
  for (int wait = 0; wait < 8; ++wait) {
    spin.begin();
    EXPECT_TRUE(spin.again());
    clock.step = 5ms;  // a handler, say
    clock.now();
    clock.step = 100ns;
  }
  EXPECT_EQ(spin.crowded_until(), TimePoint{});
}

TEST(SpinPolicy, ALostCoreInWaitsOfOneYieldIsNoticedByTheSecond) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.looks_alone = 0});
  spin.begin();
  EXPECT_TRUE(spin.again());
  clock.step = 4ms;
  spin.begin();
  EXPECT_TRUE(spin.again()) << "it might have been what went before";
  spin.begin();
  EXPECT_FALSE(spin.again());
  EXPECT_NE(spin.crowded_until(), TimePoint{});
}

TEST(SpinPolicy, ABudgetOfZeroNeverSpins) {
  SteppingClock clock;
  SpinPolicy spin(clock, {.longest = 0ns});
  EXPECT_EQ(looks_of_one_wait(spin), 0);
}

TEST(SleepOn, AReadableDescriptorWakes) {
  Bell quiet;
  Bell rung;
  ring_bell(rung.descriptor());
  const std::array descriptors{quiet.descriptor(), -1, rung.descriptor()};
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Ready);
}

TEST(SleepOn, ReturnsAtItsDeadline) {
  Bell quiet;
  const std::array descriptors{quiet.descriptor()};
  const TimePoint deadline = std::chrono::steady_clock::now() + 5ms;
  EXPECT_EQ(sleep_on(descriptors, deadline), Wake::TimedOut);
  EXPECT_GE(std::chrono::steady_clock::now(), deadline);
  EXPECT_EQ(sleep_on(descriptors, TimePoint{}), Wake::TimedOut) << "a deadline in the past";
}

TEST(SleepOn, WatchesMoreDescriptorsThanUsual) {
  std::vector<Bell> bells(40);
  std::vector<int> descriptors;
  for (const Bell& bell : bells) descriptors.push_back(bell.descriptor());
  EXPECT_EQ(sleep_on(descriptors, TimePoint{}), Wake::TimedOut);
  ring_bell(descriptors.back());
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Ready);
}

TEST(SleepOn, ASignalIsReported) {
  // The timer repeats, so that one signal before the sleep began costs only the next one.
  struct sigaction act {};
  act.sa_handler = [](int) {};
  struct sigaction before {};
  ASSERT_EQ(::sigaction(SIGALRM, &act, &before), 0);
  const itimerval every_5_ms{{0, 5000}, {0, 5000}};
  ASSERT_EQ(::setitimer(ITIMER_REAL, &every_5_ms, nullptr), 0);
  Bell quiet;
  const std::array descriptors{quiet.descriptor()};
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Interrupted);
  const itimerval off{};
  ::setitimer(ITIMER_REAL, &off, nullptr);
  ::sigaction(SIGALRM, &before, nullptr);
}

TEST(Bell, QuietNeverBlocksWhateverThePeerDidToIt) {
  Bell bell;
  ASSERT_EQ(::fcntl(bell.descriptor(), F_SETFL, 0), 0);  // what a hostile peer may do
  EXPECT_FALSE(bell.quiet());
  ring_bell(bell.descriptor());
  ring_bell(bell.descriptor());
  EXPECT_TRUE(bell.quiet());
  EXPECT_FALSE(bell.quiet());
}

}  // namespace
}  // namespace gecos::media
