#include "gecos/qos/match.hpp"

#include <gtest/gtest.h>

#include <array>

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;

const LineCapabilities shm{.name = "shm"};
const LineCapabilities lcm{.name = "lcm",
                           .between_hosts = true,
                           .reliable = true,
                           .keeps_samples = false,
                           .real_time = false,
                           .reports_death = false};

LineCapabilities measured(LineCapabilities line, Duration latency) {
  line.latency = {latency};
  return line;
}

TEST(WithUnit, RoundsToAUnitThatNeedsNoExponent) {
  EXPECT_EQ(with_unit(850ns), "0.85us");
  EXPECT_EQ(with_unit(999'400ns), "999us");
  EXPECT_EQ(with_unit(999'600ns), "1ms");
  EXPECT_EQ(with_unit(2'500us), "2.5ms");
  EXPECT_EQ(with_unit(999'600us), "0.9996s");
  EXPECT_EQ(with_unit(1'234ms), "1.234s");
  EXPECT_EQ(with_unit(12'345s), "12345s");
}

TEST(Match, AnyMediumIsTimeIndependent) {
  EXPECT_TRUE(violations({}, shm).empty());
  EXPECT_TRUE(violations({}, lcm).empty());
}

TEST(Match, HardRealtimeNeedsAMediumWithoutLossOrSharedQueue) {
  const Quality asked{.line = Class::HardRealtime};
  EXPECT_TRUE(violations(asked, shm).empty());
  const auto found = violations(asked, lcm);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].term, "class=HARD_REALTIME");
  EXPECT_EQ(found[0].why, "the medium lcm shares a queue with other programs and may lose packets");
}

TEST(Match, HardRealtimeGoesByTheStatementOfTheLaboratory) {
  const Quality asked{.line = Class::HardRealtime};
  LineCapabilities loaded = shm;
  loaded.stated = {false, "[media.shm] in lab.toml:4 says that shm is not real-time"};
  const auto found = violations(asked, loaded);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].term, "class=HARD_REALTIME");
  EXPECT_EQ(found[0].why, "[media.shm] in lab.toml:4 says that shm is not real-time");
  EXPECT_TRUE(violations({.line = Class::SoftRealtime}, loaded).empty());
  LineCapabilities separate = lcm;
  separate.stated = {true, "[media.lcm] in lab.toml:2 says that lcm is real-time"};
  EXPECT_TRUE(violations(asked, separate).empty());
}

TEST(Match, ReliableNeedsSomebodyWhoRepeats) {
  LineCapabilities bare = lcm;
  bare.reliable = false;
  ASSERT_EQ(violations({}, bare).size(), 1U);
  EXPECT_EQ(violations({}, bare)[0].term, "reliability=RELIABLE");
  EXPECT_TRUE(violations({.reliability = Reliability::BestEffort}, bare).empty());
}

TEST(Match, ReliableSamplesNeedAMediumThatLosesNone) {
  const Quality asked{.reliability = Reliability::Reliable};
  EXPECT_TRUE(violations(asked, shm, Traffic::Samples).empty());
  const auto found = violations(asked, lcm, Traffic::Samples);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].term, "reliability=RELIABLE");
  EXPECT_EQ(found[0].why, "the medium lcm may lose samples, and nothing retransmits them");
  EXPECT_TRUE(violations(asked, lcm, Traffic::Calls).empty()) << "the session retransmits calls";
}

TEST(Match, SamplesOfWhichNothingIsWrittenMayBeLost) {
  EXPECT_TRUE(violations({}, lcm, Traffic::Samples).empty());
  EXPECT_TRUE(violations({.reliability = Reliability::BestEffort}, lcm, Traffic::Samples).empty());
  LineCapabilities bare = lcm;
  bare.reliable = false;
  EXPECT_TRUE(violations({}, bare, Traffic::Samples).empty());
}

TEST(Match, MediaThatAreNotNamedAreRuledOut) {
  const Quality asked{.media = Media::Shm | Media::Can};
  EXPECT_TRUE(violations(asked, shm).empty());
  ASSERT_EQ(violations(asked, lcm).size(), 1U);
  EXPECT_EQ(violations(asked, lcm)[0].term, "media=shm|can");
  EXPECT_EQ(violations(asked, lcm)[0].why, "lcm is not one of these media");
}

TEST(Match, LcmMayBeTheOnlyOneNamed) {
  const Quality asked{.media = Media::Lcm};
  EXPECT_TRUE(violations(asked, lcm).empty());
  EXPECT_EQ(violations(asked, shm).size(), 1U);
}

TEST(Match, OneProcessIsAsGoodAsItsSharedMemory) {
  const LineCapabilities inproc{.name = "inproc"};
  EXPECT_TRUE(violations({.media = Media::Shm}, inproc).empty());
  EXPECT_TRUE(violations({.media = Media::Inproc}, inproc).empty());
  EXPECT_EQ(violations({.media = Media::Lcm | Media::Tcp}, inproc).size(), 1U);
  EXPECT_EQ(violations({.media = Media::Inproc}, shm).size(), 1U);
}

TEST(Match, AMediumNobodyHasANameForIsNotAllowed) {
  EXPECT_EQ(violations({.media = Media::Shm}, {.name = "pigeon"}).size(), 1U);
  EXPECT_TRUE(violations({}, {.name = "pigeon"}).empty());
}

TEST(Match, MeasuredLatencyIsHeldAgainstASoftRealtimeLine) {
  const Quality asked{.line = Class::SoftRealtime, .latency = 5ms};
  EXPECT_TRUE(violations(asked, measured(lcm, 5ms)).empty());
  const auto found = violations(asked, measured(lcm, 7ms));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].term, "latency=5ms");
  EXPECT_EQ(found[0].why, "lcm was measured at 7ms");
}

TEST(Match, NoAnswerIsHeldAgainstALineOnceItTookLongerThanTheBound) {
  LineCapabilities line = lcm;
  line.latency = {2s, false};
  const auto found = violations({.line = Class::SoftRealtime, .latency = 100us}, line);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].term, "latency=100us");
  EXPECT_EQ(found[0].why, "lcm gave no answer within 2s");
  EXPECT_TRUE(violations({.line = Class::SoftRealtime, .latency = 3s}, line).empty())
      << "it may still come in time";
}

TEST(Match, WhatIsNotMeasuredIsNotHeldAgainstIt) {
  EXPECT_TRUE(violations({.line = Class::SoftRealtime, .latency = 1us}, lcm).empty());
}

TEST(Match, LatencyDoesNotBindATimeIndependentLine) {
  EXPECT_TRUE(violations({.latency = 1us}, measured(lcm, 1s)).empty());
}

TEST(Match, AllViolatedTermsAreFound) {
  const Quality asked{.line = Class::HardRealtime, .latency = 1ms, .media = Media::Shm};
  EXPECT_EQ(violations(asked, measured(lcm, 2ms)).size(), 3U);
}

TEST(Rank, StaticPromisesComeBeforeMeasuredLatency) {
  const std::array lines{measured(lcm, 1us), measured(shm, 1ms)};
  EXPECT_EQ(rank({}, lines), (std::vector<std::size_t>{1, 0}));
}

TEST(Rank, LowerLatencyComesFirstAmongEquals) {
  const std::array lines{measured(shm, 2us), shm, measured(shm, 1us)};
  EXPECT_EQ(rank({}, lines), (std::vector<std::size_t>{2, 0, 1}));
}

TEST(Rank, OrderGivenDecidesTheRest) {
  const std::array lines{lcm, shm, shm};
  EXPECT_EQ(rank({}, lines), (std::vector<std::size_t>{1, 2, 0}));
}

TEST(Rank, WhatDoesNotFitIsLeftOut) {
  const std::array lines{lcm, shm};
  EXPECT_EQ(rank({.line = Class::HardRealtime}, lines), (std::vector<std::size_t>{1}));
}

TEST(Rank, DoesNotGoByTheStatementsOfTheLaboratory) {
  LineCapabilities loaded = shm;
  loaded.stated = {false, "no"};
  LineCapabilities separate = lcm;
  separate.stated = {true, "yes"};
  const std::array lines{separate, loaded};
  EXPECT_EQ(rank({}, lines), (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(rank({.line = Class::HardRealtime}, lines), (std::vector<std::size_t>{0}));
}

TEST(Choose, GivesTheBest) {
  const std::array lines{lcm, shm};
  EXPECT_EQ(choose({}, lines).value(), 1U);
}

TEST(Choose, ListsEveryMediumAndTheTermItViolates) {
  const std::array lines{measured(shm, 3ms), lcm};
  const auto chosen = choose({.line = Class::HardRealtime, .latency = 1ms}, lines);
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error(),
            "no medium meets the required quality; latency=1ms: shm was measured at 3ms; "
            "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose "
            "packets");
}

TEST(Choose, ListsAReasonThatHoldsForSeveralMediaOnce) {
  std::array lines{shm, lcm};
  for (auto& line : lines) line.stated = {false, "the lab file cannot be used"};
  EXPECT_EQ(choose({.line = Class::HardRealtime}, lines).error(),
            "no medium meets the required quality; class=HARD_REALTIME: the lab file cannot be "
            "used");
}

TEST(Choose, SaysWhenThereIsNothingToChooseFrom) {
  EXPECT_EQ(choose({}, {}).error(), "there is no medium to choose from");
}

}  // namespace
}  // namespace gecos::qos
