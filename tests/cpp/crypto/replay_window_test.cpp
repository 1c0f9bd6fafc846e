#include "gecos/crypto/replay_window.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace gecos::crypto {
namespace {

TEST(ReplayWindow, EachNumberIsFreshOnce) {
  ReplayWindow window;
  for (const std::uint64_t number : {0U, 1U, 5U, 3U, 2U, 4U, 70U, 64U, 63U, 65U}) {
    ASSERT_TRUE(window.fresh(number)) << number;
    window.mark(number);
    ASSERT_FALSE(window.fresh(number)) << number;
  }
  EXPECT_TRUE(window.fresh(6));
}

TEST(ReplayWindow, WhatIsOlderThanTheWindowIsTooOld) {
  ReplayWindow window;
  window.mark(5000);
  EXPECT_TRUE(window.fresh(5001 - ReplayWindow::size));
  EXPECT_FALSE(window.too_old(5001 - ReplayWindow::size));
  EXPECT_TRUE(window.too_old(5000 - ReplayWindow::size));
  EXPECT_FALSE(window.fresh(5000 - ReplayWindow::size));
  EXPECT_TRUE(window.too_old(0));
}

TEST(ReplayWindow, AgreesWithASetOfAllNumbersSeen) {
  std::mt19937_64 random(20'26);
  ReplayWindow window;
  std::set<std::uint64_t> seen;
  std::uint64_t highest = 0;
  for (int i = 0; i < 300'000; ++i) {
    // Mostly near the front, now and then a jump of up to four windows.
    const std::uint64_t reach = random() % 64 == 0 ? 4 * ReplayWindow::size : 24;
    const std::uint64_t base = highest + 8 > 1500 ? highest + 8 - random() % 1500 : random() % 1500;
    const std::uint64_t number = random() % 3 == 0 ? base : highest + random() % reach;
    const bool expected = number + ReplayWindow::size > highest && seen.count(number) == 0;
    ASSERT_EQ(window.fresh(number), expected) << number << " with highest " << highest;
    if (!expected) continue;
    window.mark(number);
    seen.insert(number);
    highest = std::max(highest, number);
    while (*seen.begin() + 2 * ReplayWindow::size < highest) seen.erase(seen.begin());
  }
}

}  // namespace
}  // namespace gecos::crypto
