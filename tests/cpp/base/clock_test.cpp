#include "gecos/base/clock.hpp"

#include <gtest/gtest.h>

#include "gecos/base/ids.hpp"
#include "gecos/base/moment.hpp"

namespace gecos {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
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

TEST(Ids, ShowTheNumberBehindThem) {
  EXPECT_EQ(number(FunctionCode{0xFFFFFFFFu}), 0xFFFFFFFFu);
  EXPECT_EQ(number(SessionId{7}), 7u);
  static_assert(!std::is_convertible_v<std::uint64_t, Epoch>);
  static_assert(!std::is_same_v<Epoch, IncarnationId>);
}

}  // namespace
}  // namespace gecos
