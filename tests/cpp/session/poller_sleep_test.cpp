#include "gecos/session/server/poller_sleep.hpp"

#include <gtest/gtest.h>
#include <poll.h>

namespace gecos::session {
namespace {

/// Returns whether the descriptor becomes readable within `for_ms` ms.
bool rings(const PollerSleep& sleep, int for_ms) {
  pollfd one{sleep.descriptor(), POLLIN, 0};
  return ::poll(&one, 1, for_ms) == 1;
}

TEST(PollerSleepTest, AWakeUpRingsOnceForAThreadThatCountedOnTheSleep) {
  PollerSleep sleep;
  sleep.begin();
  ASSERT_TRUE(sleep.count_on());
  EXPECT_FALSE(rings(sleep, 0)) << "it still sleeps";
  sleep.end();
  EXPECT_TRUE(rings(sleep, 10'000));
  sleep.drain();
  EXPECT_FALSE(rings(sleep, 0));
}

TEST(PollerSleepTest, AnAwakeThreadCannotBeCountedOn) {
  PollerSleep sleep;
  EXPECT_FALSE(sleep.count_on());
  sleep.begin();
  sleep.end();
  EXPECT_FALSE(sleep.count_on());
  const int several_ticks = 5 * static_cast<int>(Maintenance::tick / std::chrono::milliseconds(1));
  EXPECT_FALSE(rings(sleep, several_ticks)) << "nobody counted on its sleep";
}

TEST(PollerSleepTest, AThreadThatHasJustWokenIsNotCountedOn) {
  PollerSleep sleep;
  sleep.begin();
  sleep.end();
  sleep.begin();
  EXPECT_FALSE(sleep.count_on());
  EXPECT_TRUE(sleep.count_on()) << "it has slept since";
}

TEST(PollerSleepTest, ASecondSleepDoesNotPutTheTickOff) {
  PollerSleep sleep;
  sleep.begin();
  ASSERT_TRUE(sleep.count_on());
  sleep.end();
  ASSERT_TRUE(rings(sleep, 10'000));
  sleep.begin();
  sleep.end();  // sets no timer, since nobody has counted on the sleep again
  EXPECT_TRUE(rings(sleep, 0));
}

}  // namespace
}  // namespace gecos::session
