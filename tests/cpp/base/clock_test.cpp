#include "gecos/base/clock.hpp"

#include <gtest/gtest.h>

#include "gecos/base/clock_difference.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/base/moment.hpp"

namespace gecos {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(FakeClock, StandsStillUntilItIsMoved) {
  FakeClock clock;
  const TimePoint start = clock.now();
  EXPECT_EQ(clock.now(), start);
  clock.advance(milliseconds(250));
  EXPECT_EQ(clock.now() - start, milliseconds(250));
}

TEST(FakeClock, MovesTheTimeOfDayAlong) {
  FakeClock clock(TimePoint{seconds(7)}, seconds(1000));
  EXPECT_EQ(clock.now(), TimePoint{seconds(7)});
  EXPECT_EQ(clock.unix_time(), seconds(1000));
  clock.advance(milliseconds(1500));
  EXPECT_EQ(clock.unix_time(), milliseconds(1001500));
}

TEST(SystemClock, NeverGoesBack) {
  const SystemClock clock;
  TimePoint before = clock.now();
  for (int i = 0; i < 1000; ++i) {
    const TimePoint now = clock.now();
    ASSERT_GE(now, before);
    before = now;
  }
}

TEST(Moment, IsAnotherOneAfterATick) {
  EXPECT_NE(Moment::now(), Moment{}) << "there was none before";
  const Moment last = Moment::now();
  const SystemClock clock;
  const TimePoint begin = clock.now();
  while (clock.now() - begin < milliseconds(30)) {
  }
  EXPECT_NE(Moment::now(), last);
}

TEST(SystemClock, KnowsTheTimeOfDay) {
  EXPECT_GT(SystemClock().unix_time(), hours(24 * 365 * 50));   // after 2019
  EXPECT_LT(SystemClock().unix_time(), hours(24 * 365 * 130));  // before 2100
}

TEST(SystemClock, ReadsOneMomentByBothClocks) {
  const SystemClock clock;
  // Of a measurement, and of the value that is kept while measurements agree.
  constexpr Duration error = 2 * ClockDifference::longest_measurement;
  const TimePoint begin = clock.since_boot();
  TimeByBoth before = clock.by_both();
  while (before.since_boot - begin < milliseconds(30)) {  // several ticks of the kernel
    const TimePoint boot = clock.since_boot();
    const Duration wall = clock.unix_time();
    const TimeByBoth now = clock.by_both();
    ASSERT_GE(now.since_boot, boot);
    ASSERT_GE(now.unix_time, wall - error);
    ASSERT_GE(now.unix_time, before.unix_time - error);
    // A thread that was interrupted reads the clock late, but never in the future.
    ASSERT_LE(now.unix_time, clock.unix_time() + error);
    before = now;
  }
}

TEST(ClockDifference, IsMeasuredOnce) {
  ClockDifference known;
  const Moment tick{1'000'000, 5'000'000}, next{5'000'000, 9'000'000};
  EXPECT_FALSE(known.at(tick));
  EXPECT_TRUE(known.remember(tick, seconds(7), nanoseconds(90)));
  EXPECT_EQ(known.at(tick), seconds(7));
  EXPECT_EQ(known.at(next), seconds(7));
}

TEST(ClockDifference, IsMeasuredAgainWhenTheWallClockWasSet) {
  ClockDifference known;
  const Moment before{1'000'000, 5'000'000}, after{1'000'000, 2'005'000'000};
  known.remember(before, seconds(7), nanoseconds(90));
  EXPECT_FALSE(known.at(after));
  known.remember(after, seconds(9), nanoseconds(90));
  EXPECT_EQ(known.at(after), seconds(9));
}

TEST(ClockDifference, KeepsItsValueWhileOnlyTheErrorOfTheMeasurementChanges) {
  ClockDifference known;
  const Moment awake{1'000'000, 5'000'000}, after_a_suspension{5'000'000, 3'009'000'000};
  known.remember(awake, seconds(7), nanoseconds(90));
  EXPECT_FALSE(known.at(after_a_suspension));
  known.remember(after_a_suspension, seconds(7) - nanoseconds(40), nanoseconds(90));
  EXPECT_EQ(known.at(after_a_suspension), seconds(7));
}

TEST(ClockDifference, ForgetsAMeasurementThatWasInterrupted) {
  ClockDifference known;
  const Moment before{1'000'000, 5'000'000}, after{1'000'000, 2'005'000'000};
  EXPECT_FALSE(known.remember(before, seconds(7), milliseconds(3)));
  EXPECT_FALSE(known.at(before));
  known.remember(before, seconds(7), nanoseconds(90));
  EXPECT_FALSE(known.remember(after, seconds(9), milliseconds(3)));
  EXPECT_FALSE(known.at(after));
}

TEST(Ids, ShowTheNumberBehindThem) {
  EXPECT_EQ(number(FunctionCode{0xFFFFFFFFu}), 0xFFFFFFFFu);
  EXPECT_EQ(number(SessionId{7}), 7u);
  static_assert(!std::is_convertible_v<std::uint64_t, Epoch>);
  static_assert(!std::is_same_v<Epoch, IncarnationId>);
}

}  // namespace
}  // namespace gecos
