#include "gecos/qos/failover_plan.hpp"

#include <gtest/gtest.h>

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;
using Act = FailoverPlan::Act;

constexpr TimePoint began{1h};
constexpr Duration rest = FailoverPlan::between_searches;

TEST(FailoverPlan, NothingHappensWhileTheConnectionKeepsItsBound) {
  FailoverPlan plan;
  EXPECT_EQ(plan.look(false, false, began), Act::None);
  EXPECT_EQ(plan.look(false, true, began + 1h), Act::None);
}

TEST(FailoverPlan, ADegradedSessionSearchesOnceAtATime) {
  FailoverPlan plan;
  EXPECT_EQ(plan.look(true, false, began), Act::Search);
  EXPECT_EQ(plan.look(true, false, began + 1h), Act::None) << "the search is under way";
}

TEST(FailoverPlan, ASearchWithoutResultIsReportedOnceAndRepeatedAfterAPause) {
  FailoverPlan plan;
  ASSERT_EQ(plan.look(true, false, began), Act::Search);
  EXPECT_TRUE(plan.found_none(began + 1s));
  EXPECT_EQ(plan.look(true, false, began + 1s + rest - 1ns), Act::None);
  EXPECT_EQ(plan.look(true, false, began + 1s + rest), Act::Search);
  EXPECT_FALSE(plan.found_none(began + 10s)) << "the program knows it";
}

TEST(FailoverPlan, ASessionThatMustStayNeverSearchesAndSaysSoOnce) {
  FailoverPlan plan;
  EXPECT_EQ(plan.look(true, true, began), Act::ReportStay);
  for (Duration after = 10ms; after < 1min; after += 10ms) {
    ASSERT_EQ(plan.look(true, true, began + after), Act::None);
  }
}

TEST(FailoverPlan, ASessionThatMayMoveAgainSearchesAtOnceAndReportsNoSecondStay) {
  FailoverPlan plan;
  ASSERT_EQ(plan.look(true, true, began), Act::ReportStay);
  EXPECT_EQ(plan.look(true, false, began + 1ms), Act::Search);
  EXPECT_FALSE(plan.found_none(began + 2ms));
}

TEST(FailoverPlan, WhatIsFoundTooLateIsDroppedAndTheStayIsReported) {
  FailoverPlan plan;
  ASSERT_EQ(plan.look(true, false, began), Act::Search);
  EXPECT_EQ(plan.look(true, true, began + 1ms), Act::None) << "the search is under way";
  plan.dropped();
  EXPECT_EQ(plan.look(true, true, began + 2ms), Act::ReportStay);
}

TEST(FailoverPlan, TheNextDegradationIsJudgedAnew) {
  FailoverPlan plan;
  ASSERT_EQ(plan.look(true, false, began), Act::Search);
  ASSERT_TRUE(plan.found_none(began));
  EXPECT_EQ(plan.look(false, false, began + 1s), Act::None);
  EXPECT_EQ(plan.look(true, false, began + 2s), Act::Search) << "without the rest";
  EXPECT_TRUE(plan.found_none(began + 3s)) << "and with a report";
  ASSERT_EQ(plan.look(true, false, began + 3s + rest), Act::Search);
  plan.moved();
  EXPECT_EQ(plan.look(true, false, began + 3s + rest), Act::Search)
      << "the new medium is degraded, too";
}

}  // namespace
}  // namespace gecos::qos
