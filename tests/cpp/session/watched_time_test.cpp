#include "gecos/session/protocol/watched_time.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr TimePoint begin{seconds(100)};

TEST(WatchedTime, PassesAsTimeDoesWhileSomebodyLooks) {
  WatchedTime time(begin, milliseconds(200));
  for (int tick = 1; tick <= 50; ++tick) time.look(begin + tick * milliseconds(10));
  EXPECT_EQ(time.now(), begin + milliseconds(500));
}

TEST(WatchedTime, AJudgeWhoWasKeptFromLookingCountsOneStep) {
  WatchedTime time(begin, milliseconds(200));
  EXPECT_EQ(time.look(begin + seconds(30)), begin + milliseconds(200));
  EXPECT_EQ(time.look(begin + seconds(30) + milliseconds(10)), begin + milliseconds(210));
}

TEST(WatchedTime, NeverGoesBack) {
  WatchedTime time(begin, milliseconds(200));
  EXPECT_EQ(time.look(begin - seconds(1)), begin);
}

}  // namespace
}  // namespace gecos::session
