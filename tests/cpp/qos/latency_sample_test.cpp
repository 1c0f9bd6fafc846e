#include "gecos/qos/latency_sample.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;

constexpr Duration longest = 2s;

struct Measurement {
  LatencySample::Latency latency;
  std::size_t answers = 0;
  Duration took{};
};

/// Measures a line whose round trips are `round_trips`, and then all like the last one.
Measurement measure(const std::vector<Duration>& round_trips) {
  TimePoint now{1h};
  LatencySample sample(now, longest);
  std::size_t answers = 0;
  while (sample.wants_another(now)) {
    const Duration took = round_trips[std::min(answers, round_trips.size() - 1)];
    if (now + took > sample.gives_up()) {
      now = sample.gives_up();
      break;
    }
    now += took;
    sample.answered(took);
    ++answers;
  }
  return {sample.latency(now), answers, now - TimePoint{1h}};
}

TEST(LatencySample, IsTheMedianOfFiveRoundTrips) {
  const Measurement found = measure({40ms, 1ms, 3ms, 90ms, 2ms});
  EXPECT_EQ(found.latency.round_trip, 3ms) << "two slow answers of a busy host change nothing";
  EXPECT_TRUE(found.latency.answered);
  EXPECT_EQ(found.answers, LatencySample::most);
}

TEST(LatencySample, OfASatelliteTakesTwoRoundTrips) {
  const Measurement found = measure({600ms});
  EXPECT_EQ(found.latency.round_trip, 600ms);
  EXPECT_EQ(found.answers, 2u);
  EXPECT_EQ(found.took, 1200ms);
}

TEST(LatencySample, OfTwoRoundTripsIsTheShorterOne) {
  EXPECT_EQ(measure({700ms, 500ms}).latency.round_trip, 500ms);
}

TEST(LatencySample, NeverTakesLongerThanItsTime) {
  for (Duration each = 1ms; each < 5s; each += 7ms) {
    const Measurement found = measure({each});
    EXPECT_LE(found.took, longest);
    EXPECT_EQ(found.latency.answered, each <= longest);
    EXPECT_EQ(found.latency.round_trip, std::min(each, longest));
  }
}

}  // namespace
}  // namespace gecos::qos
