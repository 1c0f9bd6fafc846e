#include "gecos/session/protocol/sample_time.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

/// An operator may set the wall clock; the other one only goes on.
class SetClock final : public Clock {
 public:
  TimePoint now() const override { return TimePoint{passed}; }
  Duration unix_time() const override { return wall + passed; }

  Duration passed = 1h;
  Duration wall = 1'700'000'000s;
};

class SampleTimes : public ::testing::Test {
 protected:
  Duration age(const SampleTime& time) const { return clock.since_boot() - time.measured; }
  SetClock clock;
};

TEST_F(SampleTimes, AgeAsTimePassesWhateverTheWallClockIsSetTo) {
  const SampleTime time = sample_time(measured_now, clock);
  clock.passed += 100ms;
  clock.wall -= 2s;
  EXPECT_EQ(age(time), 100ms);
  clock.wall += 2h;
  EXPECT_EQ(age(time), 100ms);
}

TEST_F(SampleTimes, CarryAStampForPeople) {
  clock.passed += 1ns;
  EXPECT_EQ(sample_time(measured_now, clock).stamp_ns, 1'700'003'600'000'000'001);
}

TEST_F(SampleTimes, OfTheServantsOwnAreComparedWithTheWallClockOnce) {
  const auto stamp = (clock.unix_time() - 250ms).count();
  const SampleTime time = sample_time(stamp, clock);
  EXPECT_EQ(time.stamp_ns, stamp);
  clock.wall -= 2s;
  EXPECT_EQ(age(time), 250ms);
}

TEST_F(SampleTimes, AreNeverLaterThanNow) {
  const auto tomorrow = (clock.unix_time() + 24h).count();
  EXPECT_EQ(age(sample_time(tomorrow, clock)), 0s);
}

TEST_F(SampleTimes, OfNoSenseAreBounded) {
  for (const std::int64_t stamp : {std::int64_t{0}, std::numeric_limits<std::int64_t>::min() + 1,
                                   std::numeric_limits<std::int64_t>::max()}) {
    EXPECT_GE(age(sample_time(stamp, clock)), 0s);
  }
}

TEST_F(SampleTimes, TravelBehindTheSample) {
  Bytes sample(3, std::byte{7});
  append_measured(sample, clock.since_boot());
  EXPECT_EQ(sample.size(), 3 + measured_bytes);
  EXPECT_EQ(take_measured(sample), clock.since_boot());
  EXPECT_EQ(sample, Bytes(3, std::byte{7}));
  EXPECT_EQ(take_measured(sample), std::nullopt) << "and nothing where there is none";
}

}  // namespace
}  // namespace gecos::session
