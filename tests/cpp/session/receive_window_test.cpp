#include "gecos/session/protocol/receive_window.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace gecos::session {
namespace {

using Verdict = ReceiveWindow::Verdict;

TEST(ReceiveWindow, TakesEveryCounterOnce) {
  ReceiveWindow window;
  for (std::uint64_t counter = 1; counter <= 5000; ++counter) {
    EXPECT_EQ(window.arrived(counter), Verdict::New);
    EXPECT_EQ(window.arrived(counter), Verdict::Seen);
  }
  EXPECT_EQ(window.cumulative_ack(), 5000u);
}

TEST(ReceiveWindow, TakesEveryCounterOnceInAnyOrderOfArrival) {
  std::mt19937 random(11);
  ReceiveWindow window;
  for (std::uint64_t block = 0; block < 20; ++block) {
    std::vector<std::uint64_t> counters(500);
    std::iota(counters.begin(), counters.end(), block * 500 + 1);
    std::shuffle(counters.begin(), counters.end(), random);
    for (const auto counter : counters) EXPECT_EQ(window.arrived(counter), Verdict::New);
    for (const auto counter : counters) EXPECT_EQ(window.arrived(counter), Verdict::Seen);
  }
  EXPECT_EQ(window.cumulative_ack(), 10000u);
}

TEST(ReceiveWindow, DoesNotTakeWhatItCouldNotRemember) {
  ReceiveWindow window;
  EXPECT_EQ(window.arrived(1024), Verdict::New);
  EXPECT_EQ(window.arrived(1025), Verdict::Beyond);
  EXPECT_EQ(window.arrived(1), Verdict::New);
  EXPECT_EQ(window.arrived(1025), Verdict::New);
}

TEST(ReceiveWindow, WaitsNoMoreForWhatWasGivenUp) {
  ReceiveWindow window;
  for (const std::uint64_t counter : {1, 4, 5, 7}) EXPECT_EQ(window.arrived(counter), Verdict::New);
  window.abandoned(3);
  EXPECT_EQ(window.cumulative_ack(), 5u) << "those after it are there";
  EXPECT_EQ(window.arrived(2), Verdict::Seen);
  window.abandoned(2);
  EXPECT_EQ(window.cumulative_ack(), 5u);
  EXPECT_EQ(window.arrived(6), Verdict::New);
  EXPECT_EQ(window.cumulative_ack(), 7u);
  window.abandoned(5000);
  EXPECT_EQ(window.arrived(5000), Verdict::Seen);
  EXPECT_EQ(window.arrived(5001), Verdict::New);
}

TEST(ReceiveWindow, HoldsForAnyNumber) {
  constexpr std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  ReceiveWindow window;
  EXPECT_EQ(window.arrived(last), Verdict::Beyond);
  window.abandoned(last - 2);
  EXPECT_EQ(window.arrived(last), Verdict::New);
  EXPECT_TRUE(window.seen(last));
  EXPECT_FALSE(window.seen(last - 1));
  window.abandoned(last);
  EXPECT_EQ(window.arrived(last), Verdict::Seen);
}

TEST(ReplyCache, KeepsRepliesUntilTheyAreAcknowledged) {
  ReplyCache cache;
  cache.keep(1, Bytes(3));
  cache.keep(2, Bytes(4));
  cache.acknowledged(1);
  EXPECT_EQ(cache.find(1), nullptr);
  ASSERT_NE(cache.find(2), nullptr);
  EXPECT_EQ(cache.find(2)->size(), 4u);
}

TEST(ReplyCache, CrowdsOutTheOldest) {
  ReplyCache cache;
  for (std::uint64_t counter = 1; counter <= 513; ++counter) cache.keep(counter, Bytes(1));
  EXPECT_EQ(cache.find(1), nullptr);
  EXPECT_NE(cache.find(2), nullptr);
  cache.keep(600, Bytes(16 * 1024 * 1024));
  EXPECT_EQ(cache.find(513), nullptr);
  EXPECT_NE(cache.find(600), nullptr) << "the newest is kept whatever its size";
}

TEST(ReplyCache, KeepsLittleOfASessionThatIsLost) {
  ReplyCache cache;
  cache.keep(1, Bytes(60 * 1024));
  cache.keep(2, Bytes(60 * 1024));
  cache.shrink();
  EXPECT_EQ(cache.find(1), nullptr);
  EXPECT_NE(cache.find(2), nullptr);
  cache.keep(3, Bytes(60 * 1024));
  EXPECT_EQ(cache.find(2), nullptr);
}

}  // namespace
}  // namespace gecos::session
