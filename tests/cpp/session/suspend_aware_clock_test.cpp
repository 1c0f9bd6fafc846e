#include "gecos/session/protocol/suspend_aware_clock.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr TimePoint begin{seconds(100)};

TEST(SuspendAwareClock, PassesAsTimeDoesWhileSomebodyLooks) {
  SuspendAwareClock time(begin, milliseconds(200));
  for (int tick = 1; tick <= 50; ++tick) time.advance(begin + tick * milliseconds(10));
  EXPECT_EQ(time.now(), begin + milliseconds(500));
}

TEST(SuspendAwareClock, AJudgeWhoWasKeptFromLookingCountsOneStep) {
  SuspendAwareClock time(begin, milliseconds(200));
  EXPECT_EQ(time.advance(begin + seconds(30)), begin + milliseconds(200));
  EXPECT_EQ(time.advance(begin + seconds(30) + milliseconds(10)), begin + milliseconds(210));
}

TEST(SuspendAwareClock, NeverGoesBack) {
  SuspendAwareClock time(begin, milliseconds(200));
  EXPECT_EQ(time.advance(begin - seconds(1)), begin);
}

}  // namespace
}  // namespace gecos::session
