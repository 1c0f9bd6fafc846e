#include "gecos/session/server/handler_times.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

TEST(HandlerTimes, KnowNothingBeforeTheFirstHandler) {
  const HandlerTimes times;
  EXPECT_EQ(times.quantile(0.5), 0ns);
  EXPECT_EQ(times.quantile(1), 0ns);
  EXPECT_EQ(times.worst(), 0ns);
}

TEST(HandlerTimes, AreExactForOneHandler) {
  for (const Duration took : {Duration(1ns), Duration(127ns), Duration(128ns), Duration(3us),
                              Duration(40ms), Duration(7s), Duration(48h)}) {
    HandlerTimes times;
    times.add(took);
    EXPECT_EQ(times.quantile(0.5), took);
    EXPECT_EQ(times.quantile(0.99), took);
    EXPECT_EQ(times.worst(), took);
  }
}

TEST(HandlerTimes, CountAClockThatWentBackAsNoTime) {
  HandlerTimes times;
  times.add(-1s);
  EXPECT_EQ(times.quantile(1), 0ns);
}

TEST(HandlerTimes, ShowARareSlowHandlerInTheLastPercentAlone) {
  HandlerTimes times;
  for (int each = 0; each < 98; ++each) times.add(2us);
  times.add(1s);
  times.add(3s);
  EXPECT_LE(times.quantile(0.5), 2500ns);
  EXPECT_LE(times.quantile(0.98), 2500ns);
  EXPECT_GE(times.quantile(0.99), 1s);
  EXPECT_LE(times.quantile(0.99), 1250ms);
  EXPECT_EQ(times.worst(), 3s);
}

TEST(HandlerTimes, WeighAHandlerThatStandsForOthers) {
  HandlerTimes times;
  for (int each = 0; each < 16; ++each) times.add(1ms);
  times.add(1us, 16);
  EXPECT_LE(times.quantile(0.5), 1250ns);
  EXPECT_GE(times.quantile(0.51), 1ms);
}

/// Each quantile is the time of the handler that has this rank, or up to a quarter more.
TEST(HandlerTimes, GiveQuantilesOfRandomTimesWithinAQuarter) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(2.2, 12.0);  // 160 ns to 1000 s
  for (int round = 0; round < 50; ++round) {
    HandlerTimes times;
    std::vector<Duration> all;
    for (int each = 0; each < 200; ++each) {
      all.emplace_back(static_cast<Duration::rep>(std::pow(10.0, exponent(random))));
      times.add(all.back());
    }
    std::ranges::sort(all);
    for (const std::size_t rank :
         {std::size_t{1}, std::size_t{20}, std::size_t{100}, std::size_t{198}, std::size_t{200}}) {
      const Duration exact = all[rank - 1];
      const Duration told = times.quantile((static_cast<double>(rank) - 0.5) / 200.0);
      EXPECT_GE(told, exact);
      EXPECT_LE(told, exact + exact / 4 + 1ns);
    }
  }
}

TEST(TimedWeight, OfAnyNumberOfHandlersStandsForAboutAsMany) {
  std::uint64_t stands_for = 0;
  for (std::uint64_t number = 0; number < 100'000; ++number) {
    stands_for += timed_weight(number);
    if (number % 16 != 15) continue;
    EXPECT_EQ(stands_for, number + 1);
  }
  EXPECT_EQ(timed_weight(15), 1u);
  EXPECT_EQ(timed_weight(17), 0u);
}

}  // namespace
}  // namespace gecos::session
