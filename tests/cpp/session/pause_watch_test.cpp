#include "gecos/session/process/pause_watch.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace gecos::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr TimePoint begin{seconds(100)};
constexpr Duration gap = PauseWatch::longest_gap;

TEST(PauseWatch, SuspectsNothingBeforeTheFirstTickNorWhileMaintenanceSleepsOnPurpose) {
  PauseWatch watch;
  EXPECT_FALSE(watch.suspected(begin));
  EXPECT_FALSE(watch.tick(begin));
  ASSERT_TRUE(watch.due(TimePoint::max(), begin));
  EXPECT_FALSE(watch.suspected(begin + std::chrono::hours(1)));
  EXPECT_FALSE(watch.tick(begin + std::chrono::hours(1)));
}

TEST(PauseWatch, ATickThatIsLateByNoMoreThanTheGapIsNoPause) {
  PauseWatch watch;
  ASSERT_TRUE(watch.due(begin, begin));
  EXPECT_FALSE(watch.suspected(begin + gap));
  EXPECT_FALSE(watch.tick(begin + gap));
}

TEST(PauseWatch, EveryThreadSuspectsAPauseBeforeMaintenanceHasSeenIt) {
  PauseWatch watch;
  ASSERT_TRUE(watch.due(begin, begin));
  EXPECT_TRUE(watch.suspected(begin + gap + milliseconds(1)));
}

TEST(PauseWatch, ARestOfAServerHidesNoPause) {
  for (const auto& [rest, noticed] : {std::pair{10, 510}, {25, 525}, {60, 525}, {125, 525}}) {
    PauseWatch watch;
    ASSERT_TRUE(watch.due(begin + milliseconds(rest), begin));
    EXPECT_FALSE(watch.suspected(begin + milliseconds(noticed))) << rest;
    const TimePoint end = begin + milliseconds(noticed + 1);
    EXPECT_TRUE(watch.suspected(end)) << rest;
    EXPECT_EQ(watch.tick(end), milliseconds(noticed + 1 - rest)) << "without the rest " << rest;
  }
}

TEST(PauseWatch, ALongRestIsExpectedButForItsLastPart) {
  PauseWatch watch;
  ASSERT_TRUE(watch.due(begin + seconds(2), begin));
  EXPECT_FALSE(watch.suspected(begin + milliseconds(2400)));
  EXPECT_TRUE(watch.suspected(begin + milliseconds(2401)));
}

TEST(PauseWatch, APauseDuringATickIsSeenByTheNextOne) {
  PauseWatch watch;
  ASSERT_FALSE(watch.tick(begin));
  const TimePoint end = begin + seconds(3);
  EXPECT_TRUE(watch.suspected(end));
  EXPECT_FALSE(watch.due(end + milliseconds(10), end)) << "maintenance must not sleep over it";
  EXPECT_FALSE(watch.due(TimePoint::max(), end));
  EXPECT_EQ(watch.tick(end), seconds(3));
}

/// A clock of this world that stands where a test puts it.
class RealClock final : public Clock {
 public:
  TimePoint now() const override {
    ++readings;
    return at;
  }
  bool real() const override { return true; }
  Duration unix_time() const override { return {}; }
  TimePoint at = begin;
  mutable int readings = 0;
};

constexpr Moment tick{1'000'000'000, 5'000'000'000};
constexpr Moment next_tick{1'004'000'000, 5'004'000'000};

TEST(PauseWatch, AThreadThatAsksOftenReadsTheClockOnceATick) {
  PauseWatch watch;
  RealClock clock;
  PauseWatch::Checked checked;
  ASSERT_TRUE(watch.due(begin, begin));
  for (int question = 0; question < 100; ++question) {
    EXPECT_FALSE(watch.suspected(clock, checked, tick));
  }
  EXPECT_FALSE(watch.suspected(clock, checked, next_tick));
  EXPECT_EQ(clock.readings, 2);
}

TEST(PauseWatch, AThreadThatAskedBeforeAPauseSuspectsItAfterwardsUntilItIsJudged) {
  PauseWatch watch;
  RealClock clock;
  PauseWatch::Checked checked;
  ASSERT_TRUE(watch.due(begin, begin));
  ASSERT_FALSE(watch.suspected(clock, checked, tick));
  clock.at += seconds(3);
  const Moment later{tick.monotonic_ns + 3'000'000'000, tick.unix_ns + 3'000'000'000};
  EXPECT_TRUE(watch.suspected(clock, checked, later));
  EXPECT_TRUE(watch.suspected(clock, checked, later)) << "the question before was answered: yes";
  watch.tick(clock.at);
  EXPECT_TRUE(watch.suspected(clock, checked, later)) << "it is being judged";
  watch.judged(clock.at + milliseconds(10));
  EXPECT_FALSE(watch.suspected(clock, checked, later));
}

TEST(PauseWatch, ASuspendedMachineShowsInTheWallClockAndAStoppedProcessInTheOther) {
  PauseWatch watch;
  RealClock clock;
  PauseWatch::Checked checked;
  ASSERT_TRUE(watch.due(begin, begin));
  ASSERT_FALSE(watch.suspected(clock, checked, tick));
  clock.at = begin + seconds(3);
  EXPECT_TRUE(watch.suspected(clock, checked, {tick.monotonic_ns, tick.unix_ns + 3'000'000'000}));
  clock.at = begin;
  ASSERT_FALSE(watch.suspected(clock, checked, tick));
  clock.at = begin + seconds(3);
  EXPECT_TRUE(watch.suspected(clock, checked, {tick.monotonic_ns + 3'000'000'000, tick.unix_ns}))
      << "somebody has set the wall clock back meanwhile";
}

TEST(PauseWatch, AClockThatATestMovesIsReadEachTime) {
  PauseWatch watch;
  FakeClock clock;
  PauseWatch::Checked checked;
  ASSERT_TRUE(watch.due(clock.since_boot(), clock.since_boot()));
  ASSERT_FALSE(watch.suspected(clock, checked));
  clock.advance(seconds(3));
  EXPECT_TRUE(watch.suspected(clock, checked));
}

TEST(PauseWatch, NothingMayStartUntilThePauseIsJudged) {
  PauseWatch watch;
  ASSERT_TRUE(watch.due(begin, begin));
  const TimePoint end = begin + seconds(3);
  EXPECT_EQ(watch.tick(end), seconds(3));
  EXPECT_TRUE(watch.suspected(end)) << "it is being judged";
  watch.judged(end + milliseconds(10));
  EXPECT_FALSE(watch.suspected(end));
  EXPECT_FALSE(watch.tick(end + milliseconds(10)));
}

TEST(PauseWatch, WhoWaitsForTheJudgementGoesOnAfterIt) {
  FakeClock clock;
  PauseWatch watch;
  ASSERT_TRUE(watch.due(clock.since_boot(), clock.since_boot()));
  clock.advance(seconds(3));
  ASSERT_TRUE(watch.tick(clock.since_boot()));
  std::thread waiter([&] { watch.await_judgement(clock); });
  watch.judged(clock.since_boot());
  waiter.join();
  EXPECT_FALSE(watch.suspected(clock.since_boot()));
}

TEST(PauseWatch, SaysHowLongItWasInSeconds) {
  EXPECT_EQ(stood_still_for(milliseconds(3140)), "stood still for 3.1 s");
}

}  // namespace
}  // namespace gecos::session
