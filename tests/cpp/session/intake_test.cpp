#include "gecos/session/server/intake.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {
namespace {

using Verdict = Intake::Verdict;

constexpr Duration second = std::chrono::seconds(1);
constexpr TimePoint start{second};

wire::PacketView packet(std::uint64_t counter, ByteView body = {}, Duration deadline = {}) {
  wire::PacketView view;
  view.header.counter = counter;
  view.header.deadline = deadline;
  view.body = body;
  return view;
}

std::vector<std::uint64_t> taken(Intake& intake, TimePoint now = start) {
  std::vector<std::uint64_t> counters;
  while (const auto call = intake.next(now)) counters.push_back(call->header.counter);
  return counters;
}

TEST(Intake, TakesEachCallOnce) {
  Intake lossy(true);
  EXPECT_EQ(lossy.arrived({.counter = 1}), Verdict::Take);
  EXPECT_EQ(lossy.arrived({.counter = 1}), Verdict::Seen);
  EXPECT_EQ(lossy.arrived({.counter = 3}), Verdict::Take);
  EXPECT_EQ(lossy.arrived({.counter = 3}), Verdict::Seen);
  EXPECT_EQ(lossy.arrived({.counter = 2}), Verdict::Take);
}

TEST(Intake, IgnoresWhatIsTooFarAheadToBeRemembered) {
  Intake lossy(true);
  EXPECT_EQ(lossy.arrived({.counter = 5000}), Verdict::Ignore);
  EXPECT_FALSE(lossy.seen(5000)) << "its client sends it again";
}

TEST(Intake, ACallPutAsideWaitsForThoseBeforeIt) {
  Intake lossy(true);
  for (const std::uint64_t counter : {4U, 3U}) {
    ASSERT_EQ(lossy.arrived({.counter = counter}), Verdict::Take);
    ASSERT_TRUE(lossy.too_early(counter));
    ASSERT_TRUE(lossy.put_aside(packet(counter), start));
  }
  lossy.arrived({.counter = 1});
  EXPECT_FALSE(lossy.too_early(1));
  EXPECT_TRUE(taken(lossy).empty()) << "the second is missing";
  lossy.arrived({.counter = 2});
  EXPECT_EQ(taken(lossy), (std::vector<std::uint64_t>{3, 4}));
  EXPECT_EQ(lossy.aside(), 0U);
}

TEST(Intake, NothingIsEarlyOverAMediumThatLosesNothing) {
  Intake reliable(false);
  EXPECT_EQ(reliable.arrived({.counter = 7}), Verdict::Take);
  EXPECT_FALSE(reliable.too_early(7));
}

TEST(Intake, NothingWaitsForWhatItsClientHasGivenUp) {
  Intake lossy(true);
  lossy.arrived({.counter = 2});
  lossy.put_aside(packet(2), start);
  lossy.arrived({.counter = 5});
  lossy.put_aside(packet(5), start);
  EXPECT_TRUE(lossy.abandon_up_to(4));
  EXPECT_FALSE(lossy.is_aside(2)) << "it was given up itself";
  EXPECT_EQ(taken(lossy), std::vector<std::uint64_t>{5});
  EXPECT_FALSE(lossy.abandon_up_to(4)) << "that is known";
  EXPECT_EQ(lossy.arrived({.counter = 3}), Verdict::Seen) << "it comes too late to start";
}

TEST(Intake, WhatIsBarredNeverStarts) {
  Intake lossy(true);
  EXPECT_EQ(lossy.reject_late(1), ReceiveWindow::Verdict::New);
  EXPECT_EQ(lossy.arrived({.counter = 1}), Verdict::Seen);
}

TEST(Intake, TheTimeAsideCountsAgainstTheDeadline) {
  Intake lossy(true);
  lossy.arrived({.counter = 2});
  lossy.put_aside(packet(2, {}, 3 * second), start);
  lossy.arrived({.counter = 1});
  const auto call = lossy.next(start + second);
  ASSERT_TRUE(call);
  EXPECT_EQ(call->header.deadline, 2 * second);
}

TEST(Intake, TheTimeAsideCountsTowardsTheAge) {
  Intake lossy(true);
  lossy.arrived({.counter = 2});
  lossy.put_aside(packet(2), start, 3 * second);
  lossy.arrived({.counter = 1});
  const auto call = lossy.next(start + second);
  ASSERT_TRUE(call);
  EXPECT_EQ(call->age, 4 * second);
}

TEST(Intake, ADeadlineThatPassedAsideIsNotTakenForNone) {
  Intake lossy(true);
  lossy.arrived({.counter = 2});
  lossy.put_aside(packet(2, {}, second), start);
  lossy.arrived({.counter = 1});
  EXPECT_EQ(lossy.next(start + 5 * second)->header.deadline, Duration{1});
}

TEST(Intake, KeepsABoundedNumberOfBytesAside) {
  Intake lossy(true);
  const Bytes large(ObjectQueue::most_bytes_of_client);
  EXPECT_TRUE(lossy.put_aside(packet(2, large), start)) << "one alone is kept whatever it takes";
  EXPECT_FALSE(lossy.put_aside(packet(3, large), start));
  EXPECT_FALSE(lossy.is_aside(3));
  lossy.drop(2);
  EXPECT_TRUE(lossy.put_aside(packet(3, large), start));
}

TEST(Intake, ListsWhatIsAsideByCounter) {
  Intake lossy(true);
  for (const std::uint64_t counter : {9U, 4U, 6U}) lossy.put_aside(packet(counter), start);
  EXPECT_EQ(lossy.first_aside(), 4U);
  EXPECT_EQ(lossy.first_aside(4), 6U);
  EXPECT_EQ(lossy.first_aside(9), std::nullopt);
}

TEST(Intake, AReleaseArrivesOnlyAfterAllThatWasIssuedBeforeIt) {
  Intake lossy(true);
  EXPECT_EQ(lossy.arrived({.counter = 2, .needs_all = true}), Verdict::Ignore);
  lossy.arrived({.counter = 1});
  EXPECT_EQ(lossy.arrived({.counter = 2, .needs_all = true}), Verdict::Take);
}

TEST(Intake, WhatLayUnreadForTooLongIsSentAgainOrRefused) {
  Intake lossy(true);
  lossy.accept_within(second);
  EXPECT_EQ(lossy.arrived({.counter = 1, .age = second}), Verdict::Take);
  EXPECT_EQ(lossy.arrived({.counter = 2, .age = second + Duration{1}}), Verdict::Ignore);
  EXPECT_FALSE(lossy.seen(2));

  Intake reliable(false);
  reliable.accept_within(second);
  EXPECT_EQ(reliable.arrived({.counter = 1, .age = 2 * second}), Verdict::Take)
      << "it waited for a handler";
  EXPECT_EQ(reliable.arrived({.counter = 2, .age = 2 * second, .from_a_pause = true}),
            Verdict::TooLate)
      << "this process stood still";
  EXPECT_TRUE(reliable.seen(2));
}

TEST(Intake, ACallOfAnyAgeIsTakenWhereItsClientAsksForNoBound) {
  Intake lossy(true);
  EXPECT_EQ(lossy.arrived({.counter = 1, .age = 1000 * second}), Verdict::Take);
}

TEST(Intake, RemembersThatItsClientHasWithdrawn) {
  Intake intake(false);
  EXPECT_FALSE(intake.withdrawn());
  intake.withdraw();
  EXPECT_TRUE(intake.withdrawn());
}

}  // namespace
}  // namespace gecos::session
