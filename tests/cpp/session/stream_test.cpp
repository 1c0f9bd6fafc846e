#include <limits>
#include <thread>

#include "../settles.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::StreamEnd;

class Streams : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
  }
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(Streams);

TEST_P(Streams, GiveSamplesInOrderWithTheirSequence) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  EXPECT_FALSE(level->latest()) << "nothing before the first";
  for (std::int32_t value = 1; value <= 5; ++value) {
    servant_.publish(value);
    const auto sample = level->next(10s);
    ASSERT_TRUE(sample) << to_string(sample.error());
    EXPECT_EQ(sample->value, value);
    EXPECT_EQ(sample->lost, 0u);
  }
  EXPECT_EQ(level->latest()->value, 5) << "the newest stays";
}

TEST_P(Streams, SayHowOldASampleIs) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(1);
  const auto first = level->next(10s);
  ASSERT_TRUE(first) << to_string(first.error());
  EXPECT_GE(first->age, 0s);
  EXPECT_LT(first->age, 10s);
  EXPECT_GE(level->latest()->age, first->age) << "read again it is older";
  servant_.publish(2, gecos::unix_now_ns() - 3'000'000'000);
  const auto older = level->next(10s);
  ASSERT_TRUE(older) << to_string(older.error());
  EXPECT_GE(older->age, 2900ms) << "measured 3 s before it was published";
  EXPECT_LT(older->age, 13s);
}

TEST_P(Streams, GiveASampleWithANonsensicalStampAnAge) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  for (const std::int64_t stamp : {std::int64_t{0}, std::numeric_limits<std::int64_t>::max(),
                                   std::numeric_limits<std::int64_t>::min() + 1}) {
    servant_.publish(1, stamp);
    const auto sample = level->next(10s);
    ASSERT_TRUE(sample) << to_string(sample.error());
    EXPECT_GE(sample->age, 0s);
  }
}

TEST_P(Streams, KeepTheLatestForWhoComesLater) {
  servant_.publish(41);
  servant_.publish(42);
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto sample = level->next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 42);
}

TEST_P(Streams, GoOnBehindASampleThatDoesNotDecode) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(1);
  ASSERT_TRUE(level->next(10s));
  servant_.publish_damaged();
  servant_.publish_damaged();
  EXPECT_EQ(level->unreadable(), 0u) << "it has not come to them";
  servant_.publish(4);
  const auto sample = level->next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 4);
  EXPECT_EQ(sample->lost, 2u);
  EXPECT_EQ(level->unreadable(), 2u);
}

TEST_P(Streams, HaveNoLatestWhileTheNewestDoesNotDecode) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish_damaged();
  EXPECT_TRUE(settles([&] { return !level->latest() && level->unreadable() == 1; }));
  EXPECT_FALSE(level->latest());
  EXPECT_EQ(level->unreadable(), 1u) << "each counts once";
  const auto nothing = level->next(0s);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error(), StreamEnd::Nothing) << "the stream goes on";
  servant_.publish(2);
  ASSERT_TRUE(level->next(10s));
  EXPECT_EQ(level->latest()->value, 2);
  EXPECT_EQ(level->unreadable(), 1u);
}

TEST_P(Streams, SayThatNothingCame) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto sample = level->next(1ms);
  ASSERT_FALSE(sample);
  EXPECT_EQ(sample.error(), StreamEnd::Nothing);
}

TEST_P(Streams, WakeAReaderThatSleeps) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  std::int32_t value = 0;
  std::thread reader([&] {
    while (value < 3) {
      const auto sample = level->next(10s);
      if (!sample) return;
      value = sample->value;
    }
  });
  // Each is published once the reader may be asleep again, which the next call does not disturb.
  for (std::int32_t next = 1; next <= 3; ++next) {
    servant_.publish(next);
    ASSERT_TRUE(gecos::ping(probe_).get());
  }
  reader.join();
  EXPECT_EQ(value, 3);
}

TEST_P(Streams, AreReadWhileACommandRuns) {
  const auto lease = gecos::actor(probe_);
  ASSERT_TRUE(lease) << lease.error();
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto move = probe_.move(1);
  servant_.await_moves(1);
  std::thread waits([&] { move.wait(); });
  servant_.publish(8);
  const auto sample = level->next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 8);
  servant_.open_gate();
  waits.join();
}

TEST_P(Streams, EndWithTheirServer) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  server_.reset();
  const auto sample = level->next(10s);
  ASSERT_FALSE(sample);
  EXPECT_EQ(sample.error(), StreamEnd::Lost);
}

TEST_P(Streams, WhoOnlyAsksForTheNewestIsToldThatTheServerIsGone) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(8);
  ASSERT_TRUE(level->next(10s));
  ASSERT_TRUE(level->latest());
  EXPECT_FALSE(level->lost());
  server_.reset();
  EXPECT_TRUE(settles([&] { return !level->latest(); })) << "nobody waits on this session";
  EXPECT_TRUE(level->lost());
}

TEST_P(Streams, GiveWhatCameBeforeTheLoss) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(1);
  ASSERT_TRUE(level->next(10s));
  servant_.publish(2);
  server_.reset();
  ASSERT_TRUE(settles([&] { return level->lost(); }));
  EXPECT_FALSE(level->latest());
  const auto before = level->next(0s);
  ASSERT_TRUE(before) << to_string(before.error());
  EXPECT_EQ(before->value, 2);
  EXPECT_EQ(level->next(0s).error(), StreamEnd::Lost);
}

TEST_P(Streams, GoOnForOneReaderWhenAnotherEnds) {
  auto level = probe_.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  {
    auto second = probe_.level(gecos::stream);
    ASSERT_TRUE(second) << second.error();
  }
  ASSERT_TRUE(gecos::ping(probe_).get());
  servant_.publish(5);
  const auto sample = level->next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 5);
}

}  // namespace
