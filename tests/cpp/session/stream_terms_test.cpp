// `lifespan`, `deadline` and `liveliness` of a stream, at its reader, over every medium. Which
// samples they withhold is tested with a fake clock (qos/reception_test).
#include "../settles.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::StreamEnd;
using gecos::qos::Liveliness;
using gecos::qos::StreamCounts;

bool decode(gecos::wire::Decoder& from, std::int32_t& value) { return from.get(value, "value"); }

class StreamTerms : public probe::OverMedia {
 protected:
  using Level = gecos::Stream<std::int32_t>;

  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
  }
  /// Subscribes to the level as a program does whose interface declares `terms`.
  Level level(const gecos::qos::Quality& terms) {
    gecos::StreamDescription described = probe::description().streams[0];
    described.quality = terms;
    auto core = probe_.session()->subscribe(described);
    if (!core) throw std::runtime_error(core.error().text);
    return {*std::move(core), &decode};
  }
  void publish_old(std::int32_t value) {
    servant_.publish(value, gecos::unix_now_ns() - 3'600'000'000'000);
  }
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(StreamTerms);

TEST_P(StreamTerms, ASampleThatIsOlderThanItsLifespanIsNeverReturned) {
  Level brief = level({.lifespan = 20min});
  servant_.publish(1);
  ASSERT_TRUE(brief.next(10s));
  publish_old(2);
  publish_old(3);
  servant_.publish(4);
  const auto sample = brief.next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 4);
  EXPECT_EQ(sample->lost, 2u) << "they were not read";
  EXPECT_EQ(brief.counts(), (StreamCounts{.received = 2, .expired = 2}));
  publish_old(5);
  EXPECT_TRUE(settles([&] { return !brief.latest(); }));
  EXPECT_FALSE(brief.latest()) << "the newest one is too old";
  EXPECT_EQ(brief.next(0s).error(), StreamEnd::Nothing);
  EXPECT_EQ(brief.counts().expired, 3u) << "each counts once";
  EXPECT_TRUE(brief.alive());
}

TEST_P(StreamTerms, WithoutALifespanEverySampleIsReturned) {
  Level all = level({});
  publish_old(1);
  const auto sample = all.next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 1);
}

TEST_P(StreamTerms, ASilenceIsReportedOnceAndTheStreamGoesOn) {
  Level strict = level({.deadline = 20ms});
  EXPECT_EQ(strict.next(10s).error(), StreamEnd::Late) << "within the deadline, not the patience";
  EXPECT_GE(strict.counts().missed_deadlines, 1u);
  EXPECT_EQ(strict.next(1ms).error(), StreamEnd::Nothing) << "it was told already";
  servant_.publish(1);
  const auto sample = strict.next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 1);
  const std::uint64_t missed = strict.counts().missed_deadlines;
  EXPECT_EQ(strict.next(10s).error(), StreamEnd::Late) << "another silence";
  EXPECT_GT(strict.counts().missed_deadlines, missed);
  EXPECT_TRUE(strict.alive()) << "its process lives";
}

TEST_P(StreamTerms, AWriterThatVouchesForItselfIsDeadWhileItIsSilent) {
  Level own = level({.deadline = 20ms, .liveliness = Liveliness::Manual});
  servant_.publish(1);
  // Before it a silence may be reported, on a slow machine.
  ASSERT_TRUE(settles([&] { return own.next(10s).has_value(); }));
  EXPECT_TRUE(own.alive());
  EXPECT_EQ(own.next(10s).error(), StreamEnd::Late);
  EXPECT_FALSE(own.alive());
  EXPECT_FALSE(own.latest());
  EXPECT_FALSE(own.lost());
  servant_.publish(2);
  const auto sample = own.next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_TRUE(own.alive());
  server_.reset();
  EXPECT_TRUE(settles([&] { return !own.alive(); }));
}

TEST_P(StreamTerms, WhatLatestPassesOverIsNotLost) {
  Level all = level({});
  servant_.publish(1);
  ASSERT_TRUE(all.next(10s));
  for (std::int32_t value = 2; value <= 5; ++value) servant_.publish(value);
  ASSERT_TRUE(settles([&] {
    const auto newest = all.latest();
    return newest && newest->value == 5;
  }));
  const StreamCounts counts = all.counts();
  EXPECT_EQ(counts.lost, 0u);
  EXPECT_EQ(counts.received + counts.skipped, 5u);
}

TEST_P(StreamTerms, WhatIsBeyondTheDepthIsLostAndCounted) {
  Level all = level({});
  servant_.publish(1);
  const auto first = all.next(10s);
  ASSERT_TRUE(first);
  for (std::int32_t value = 2; value <= 101; ++value) servant_.publish(value);
  ASSERT_TRUE(settles([&] {
    const auto sample = all.next(1s);
    return sample && sample->value == 101;
  }));
  const StreamCounts counts = all.counts();
  EXPECT_EQ(counts.received + counts.lost, 101u);
  constexpr std::uint64_t kept = 16;
  if (GetParam() == gecos::media::Kind::Lcm) {  // where some may arrive late, or not at all
    EXPECT_GE(counts.lost, 1u);
  } else {
    EXPECT_EQ(counts.lost, 100 - kept);
  }
  EXPECT_EQ(counts.skipped, 0u);
}

}  // namespace
