// The samples of a stream that are kept, over every medium.
#include <algorithm>
#include <optional>
#include <random>
#include <stdexcept>

#include "../settles.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;

constexpr std::int32_t depth = 16;  // the server's default

bool decode(gecos::wire::Decoder& from, std::int32_t& value) { return from.get(value, "value"); }

class History : public probe::OverMedia {
 protected:
  using Level = gecos::Stream<std::int32_t>;
  using Values = std::vector<std::int32_t>;

  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
  }
  Level level(const gecos::qos::Quality& terms = {}) {
    gecos::StreamDescription described = probe::description().streams[0];
    described.quality = terms;
    auto core = probe_.session()->subscribe(described);
    if (!core) throw std::runtime_error(core.error().text);
    return {*std::move(core), &decode};
  }
  void publish_old(std::int32_t value) {
    servant_.publish(value, gecos::unix_now_ns() - 3'600'000'000'000);
  }
  static Values values_of(Level& stream) {
    Values values;
    for (const auto& sample : stream.history()) values.push_back(sample.value);
    return values;
  }
  probe::Probe probe_;
};
PROBE_OVER_MEDIA(History);

TEST_P(History, IsEmptyBeforeTheFirstSample) { EXPECT_TRUE(level().history().empty()); }

TEST_P(History, HasNumbersTimesAndAges) {
  Level all = level();
  servant_.publish(1);
  publish_old(2);
  ASSERT_TRUE(settles([&] { return all.history().size() == 2; }));
  const auto kept = all.history();
  for (const std::size_t i : {0, 1}) {
    const auto read = all.next(30s);
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(kept[i].value, read->value);
    EXPECT_EQ(kept[i].sequence, read->sequence);
    EXPECT_EQ(kept[i].stamp, read->stamp);
    EXPECT_EQ(kept[i].lost, 0u);
  }
  EXPECT_LT(kept[0].age, 30min);
  EXPECT_GT(kept[1].age, 30min);
}

/// Derives what a reader must find from all that was published. The reader has subscribed before.
class Model {
 public:
  void publish(bool old) { old_.push_back(old); }
  /// The value of the newest sample, which is also its number; 0 before the first one.
  std::int32_t newest() const { return static_cast<std::int32_t>(old_.size()); }
  std::vector<std::int32_t> history() const {
    std::vector<std::int32_t> values;
    for (std::int32_t value = oldest(); value <= newest(); ++value) {
      if (!old(value)) values.push_back(value);
    }
    return values;
  }
  /// What next() returns; nothing if there is no sample.
  std::optional<std::int32_t> next() {
    for (std::int32_t value = std::max(read_ + 1, oldest()); value <= newest(); ++value) {
      read_ = value;
      if (!old(value)) return value;
    }
    return std::nullopt;
  }

 private:
  bool old(std::int32_t value) const { return old_[static_cast<std::size_t>(value - 1)]; }
  std::int32_t oldest() const { return std::max(1, newest() - depth + 1); }

  std::vector<bool> old_;
  std::int32_t read_ = 0;
};

TEST_P(History, HasTheNewestSamplesOfTheDepthWithinTheirLifespanAndReadsNone) {
  std::mt19937 random(7);
  const auto pick = [&](int most) { return std::uniform_int_distribution(0, most)(random); };
  Level brief = level({.lifespan = 20min});
  Model model;
  for (int step = 0; step < 200; ++step) {
    for (int left = pick(5); left > 0; --left) {
      const bool old = pick(3) == 0;
      model.publish(old);
      if (old) {
        publish_old(model.newest());
      } else {
        servant_.publish(model.newest());
      }
    }
    const auto counts = brief.counts();
    ASSERT_TRUE(settles([&] { return values_of(brief) == model.history(); })) << "step " << step;
    EXPECT_EQ(brief.counts(), counts);
    for (int left = pick(4); left > 0; --left) {
      const auto expected = model.next();
      const auto read = brief.next(0s);
      ASSERT_EQ(read.has_value(), expected.has_value()) << "step " << step;
      if (!read) continue;
      EXPECT_EQ(read->value, *expected) << "step " << step;
    }
  }
}

TEST_P(History, TellsHowManySamplesAreMissingBetweenTwo) {
  Level brief = level({.lifespan = 20min});
  servant_.publish(1);
  publish_old(2);
  publish_old(3);
  servant_.publish(4);
  servant_.publish_damaged();
  servant_.publish(6);
  ASSERT_TRUE(settles([&] { return values_of(brief) == (Values{1, 4, 6}); }));
  const auto kept = brief.history();
  EXPECT_EQ(kept[0].lost, 0u);
  EXPECT_EQ(kept[1].lost, 2u);
  EXPECT_EQ(kept[2].lost, 1u);
  EXPECT_EQ(brief.unreadable(), 0u) << "nothing was read";
}

TEST_P(History, BeginsBeforeTheSubscriptionWhereTheMemoryIsSharedAndElsewhereWithTheNewest) {
  Level early = level();
  for (std::int32_t value = 1; value <= 5; ++value) servant_.publish(value);
  ASSERT_TRUE(settles([&] { return values_of(early).size() == 5; }));
  Level late = level();
  const Values kept = GetParam() == Kind::Lcm ? Values{5} : Values{1, 2, 3, 4, 5};
  EXPECT_TRUE(settles([&] { return values_of(late) == kept; }));
  const auto first = late.next(30s);
  ASSERT_TRUE(first) << first.error();
  EXPECT_EQ(first->value, 5) << "reading begins with the newest sample";
  EXPECT_EQ(first->lost, 0u);
}

TEST_P(History, StaysAfterTheEndOfTheServer) {
  Level all = level();
  for (std::int32_t value = 1; value <= 3; ++value) servant_.publish(value);
  ASSERT_TRUE(settles([&] { return values_of(all).size() == 3; }));
  server_.reset();
  ASSERT_TRUE(settles([&] { return all.lost(); }));
  EXPECT_FALSE(all.latest());
  EXPECT_EQ(values_of(all), (Values{1, 2, 3}));
}

TEST_P(History, IsEmptyAfterTheLabWasClosed) {
  Level all = level();
  servant_.publish(1);
  ASSERT_TRUE(settles([&] { return values_of(all).size() == 1; }));
  lab_.close();
  EXPECT_TRUE(all.history().empty());
}

}  // namespace
