#include "gecos/qos/latency_watch.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;
using Change = LatencyWatch::Change;

/// A connection whose delay the test sets, and a clock that it moves.
class Line {
 public:
  explicit Line(Duration bound) : watch(bound) {}

  /// Runs the line for `time`, as the maintenance thread does, every 10 ms.
  void run(Duration time) {
    for (const TimePoint end = now + time; now < end; now += 10ms) {
      if (under_way_ && now >= *under_way_ + delay) {
        const Duration took = now - *under_way_;
        under_way_.reset();
        note(watch.answered(took, now));
      }
      note(watch.look(now));
      if (!watch.probe_due(now)) continue;
      watch.sent(now);
      under_way_ = now;
      ++probes;
    }
  }

  LatencyWatch watch;
  TimePoint now{1h};
  Duration delay{};
  int probes = 0;
  std::vector<Change> changes;

 private:
  void note(Change change) {
    if (change != Change::None) changes.push_back(change);
  }
  std::optional<TimePoint> under_way_;
};

TEST(LatencyWatch, ALineThatKeepsItsBoundIsProbedOnceASecondAndNeverChanges) {
  Line line(50ms);
  line.delay = 50ms;
  line.run(10s);
  EXPECT_TRUE(line.changes.empty());
  EXPECT_EQ(line.probes, 10);
  EXPECT_EQ(line.watch.round_trip(), 50ms);
}

TEST(LatencyWatch, ADelayGivesOneChangeAndItsEndAnother) {
  Line line(50ms);
  line.run(3s);
  line.delay = 600ms;
  line.run(20s);
  EXPECT_EQ(line.changes, std::vector{Change::Degraded});
  EXPECT_TRUE(line.watch.degraded());
  line.delay = 10ms;
  line.run(20s);
  EXPECT_EQ(line.changes, (std::vector{Change::Degraded, Change::Recovered}));
}

TEST(LatencyWatch, ItIsDegradedAtTheLatestTwoSecondsAfterTheDelayBegan) {
  Line line(50ms);
  line.run(3s);
  line.delay = 100ms;
  line.run(LatencyWatch::usual_pause + 50ms + LatencyWatch::judged_after + 20ms);
  EXPECT_EQ(line.changes, std::vector{Change::Degraded});
}

TEST(LatencyWatch, ASlowAnswerAmongQuickOnesIsNoChange) {
  Line line(50ms);
  for (int times = 0; times < 20; ++times) {
    line.delay = 900ms;
    line.run(940ms);
    line.delay = 0ms;
    line.run(1500ms);
  }
  EXPECT_TRUE(line.changes.empty());
}

TEST(LatencyWatch, AProbeWithoutAnswerCountsAsSoonAsItIsTooLate) {
  LatencyWatch watch(50ms);
  TimePoint now{1h};
  watch.sent(now);
  EXPECT_FALSE(watch.probe_due(now + 1h)) << "one is under way";
  EXPECT_EQ(watch.look(now + 50ms), Change::None);
  EXPECT_EQ(watch.look(now + 60ms), Change::None);
  EXPECT_EQ(watch.look(now + 1059ms), Change::None);
  EXPECT_EQ(watch.look(now + 1060ms), Change::Degraded);
  EXPECT_EQ(watch.look(now + 5s), Change::None) << "once";
}

TEST(LatencyWatch, AProbeThatFailsTellsNothing) {
  LatencyWatch watch(50ms);
  TimePoint now{1h};
  for (int times = 0; times < 100; ++times) {
    watch.sent(now);
    watch.failed(now += 1s);
  }
  EXPECT_FALSE(watch.degraded());
  EXPECT_FALSE(watch.round_trip());
}

TEST(LatencyWatch, ChangesAlternateAndAreASecondApartWhateverTheDelayDoes) {
  std::mt19937 random(1);
  for (int runs = 0; runs < 50; ++runs) {
    Line line(50ms);
    TimePoint changed = line.now;
    std::size_t known = 0;
    for (int steps = 0; steps < 400; ++steps) {
      line.delay = std::chrono::milliseconds(std::uniform_int_distribution(0, 110)(random));
      line.run(std::chrono::milliseconds(std::uniform_int_distribution(10, 2000)(random)));
      if (line.changes.size() == known) continue;
      ASSERT_LE(line.changes.size(), known + 3);
      while (known < line.changes.size()) {
        ASSERT_EQ(line.changes[known], known % 2 == 0 ? Change::Degraded : Change::Recovered);
        ++known;
      }
      changed = line.now;
    }
    EXPECT_EQ(line.watch.degraded(), known % 2 == 1);
    EXPECT_GE(line.now, changed);
  }
}

}  // namespace
}  // namespace gecos::qos
