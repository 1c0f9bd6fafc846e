#include "gecos/qos/requested_quality.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;

auto terms_of(const Quality& quality) {
  return std::tuple(quality.line, quality.reliability, quality.deadline, quality.start_by,
                    quality.latency, quality.lifespan, quality.liveliness, quality.depth,
                    quality.media, quality.on_degraded);
}

struct Row {
  const char* what;
  Quality declared;
  RequestedQuality requested;
  Quality expected;
};

const std::vector<Row>& rows() {
  static const std::vector<Row> all = {
      {"nothing is requested of nothing", {}, {}, {}},

      {"a class", {}, {.line = Class::SoftRealtime}, {.line = Class::SoftRealtime}},
      {"a stricter class",
       {.line = Class::SoftRealtime},
       {.line = Class::HardRealtime},
       {.line = Class::HardRealtime}},
      {"a looser class",
       {.line = Class::HardRealtime},
       {.line = Class::SoftRealtime},
       {.line = Class::HardRealtime}},
      {"no class", {.line = Class::SoftRealtime}, {}, {.line = Class::SoftRealtime}},

      {"RELIABLE",
       {},
       {.reliability = Reliability::Reliable},
       {.reliability = Reliability::Reliable}},
      {"RELIABLE of BEST_EFFORT",
       {.reliability = Reliability::BestEffort},
       {.reliability = Reliability::Reliable},
       {.reliability = Reliability::Reliable}},
      {"BEST_EFFORT of RELIABLE",
       {.reliability = Reliability::Reliable},
       {.reliability = Reliability::BestEffort},
       {.reliability = Reliability::Reliable}},
      {"BEST_EFFORT of the default, with which calls are RELIABLE",
       {},
       {.reliability = Reliability::BestEffort},
       {}},
      {"the default of BEST_EFFORT",
       {.reliability = Reliability::BestEffort},
       {},
       {.reliability = Reliability::BestEffort}},

      {"a deadline", {}, {.deadline = 2s}, {.deadline = 2s}},
      {"a shorter deadline", {.deadline = 3s}, {.deadline = 2s}, {.deadline = 2s}},
      {"a longer deadline", {.deadline = 2s}, {.deadline = 3s}, {.deadline = 2s}},
      {"no deadline", {.deadline = 2s}, {}, {.deadline = 2s}},
      {"a negative deadline", {.deadline = 2s}, {.deadline = -1s}, {.deadline = 2s}},
      {"a negative deadline of none", {}, {.deadline = -1s}, {}},
      {"an endless deadline", {}, {.deadline = Duration::max()}, {}},

      {"a lifespan", {}, {.lifespan = 2s}, {.lifespan = 2s}},
      {"a shorter lifespan", {.lifespan = 3s}, {.lifespan = 2s}, {.lifespan = 2s}},
      {"a longer lifespan", {.lifespan = 2s}, {.lifespan = 3s}, {.lifespan = 2s}},
      {"no lifespan", {.lifespan = 2s}, {}, {.lifespan = 2s}},
      {"an endless lifespan", {}, {.lifespan = Duration::max()}, {}},

      {"MANUAL", {}, {.liveliness = Liveliness::Manual}, {.liveliness = Liveliness::Manual}},
      {"AUTOMATIC of MANUAL",
       {.liveliness = Liveliness::Manual},
       {.liveliness = Liveliness::Automatic},
       {.liveliness = Liveliness::Manual}},

      {"each term is judged by itself",
       {.line = Class::HardRealtime, .deadline = 2s, .lifespan = 1s},
       {.line = Class::SoftRealtime,
        .reliability = Reliability::Reliable,
        .deadline = 1s,
        .lifespan = 2s},
       {.line = Class::HardRealtime,
        .reliability = Reliability::Reliable,
        .deadline = 1s,
        .lifespan = 1s}},
      {"what cannot be requested stays as it is",
       {.start_by = 1s,
        .latency = 5ms,
        .depth = 4,
        .media = Media::Shm,
        .on_degraded = OnDegraded::Fail},
       {.line = Class::SoftRealtime, .deadline = 2s},
       {.line = Class::SoftRealtime,
        .deadline = 2s,
        .start_by = 1s,
        .latency = 5ms,
        .depth = 4,
        .media = Media::Shm,
        .on_degraded = OnDegraded::Fail}},
  };
  return all;
}

TEST(RequestedQuality, MakesEachTermStricterAndNoneLooser) {
  for (const Row& row : rows()) {
    EXPECT_EQ(terms_of(stricter(row.declared, row.requested)), terms_of(row.expected)) << row.what;
  }
}

TEST(RequestedQuality, GivesTheSameWhenItIsAppliedTwice) {
  for (const Row& row : rows()) {
    EXPECT_EQ(terms_of(stricter(row.expected, row.requested)), terms_of(row.expected)) << row.what;
  }
}

TEST(RequestedQuality, OfARealTimeClassMakesADeclaredLatencyBind) {
  EXPECT_FALSE(binds_latency({.latency = 5ms}));
  EXPECT_TRUE(binds_latency(stricter({.latency = 5ms}, {.line = Class::SoftRealtime})));
}

}  // namespace
}  // namespace gecos::qos
