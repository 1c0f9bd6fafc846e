#include "gecos/session/protocol/inward_sample.hpp"

#include <gtest/gtest.h>

#include "../wire/json.hpp"
#include "gecos/session/server/inward_admission.hpp"

namespace gecos::session {
namespace {

using gecos::testing::Json;
using gecos::testing::to_hex;

Bytes written(const InwardHeader& header, const Bytes& value) {
  Bytes bytes(inward_header_size + value.size());
  write_inward_header(std::span(bytes).first<inward_header_size>(), header);
  std::copy(value.begin(), value.end(), bytes.begin() + inward_header_size);
  return bytes;
}

TEST(InwardSample, AgreesWithTheSharedVectors) {
  const Json vectors = Json::from_vectors("inward_sample.json");
  ASSERT_FALSE(vectors["accepted"].items.empty());
  for (const Json& json : vectors["accepted"].items) {
    const InwardHeader header{SessionId{json["session"].natural()}, Epoch{json["epoch"].natural()},
                              json["command"].natural()};
    const Bytes bytes = written(header, json["value"].bytes());
    EXPECT_EQ(to_hex(bytes), json["bytes"].text);
    const auto sample = read_inward_sample(bytes);
    ASSERT_TRUE(sample) << sample.error().message();
    EXPECT_EQ(sample->header, header);
    EXPECT_EQ(to_hex(sample->value), json["value"].text);
  }
}

TEST(InwardSample, AHeaderThatIsCutShortIsRefusedWithTheFieldInWhichItEnds) {
  const Json vectors = Json::from_vectors("inward_sample.json");
  ASSERT_FALSE(vectors["refused"].items.empty());
  for (const Json& json : vectors["refused"].items) {
    const auto sample = read_inward_sample(json["bytes"].bytes());
    ASSERT_FALSE(sample) << json["bytes"].text;
    EXPECT_EQ(sample.error().problem, wire::DecodeProblem::Truncated);
    EXPECT_EQ(sample.error().field, json["field"].text);
  }
}

constexpr InwardSender sender{SessionId{9}, true, Epoch{3}, 4};
constexpr InwardHeader fitting{SessionId{9}, Epoch{3}, 4};

TEST(InwardAdmission, ASampleForTheRunningCommandIsAdmitted) {
  InwardAdmission admission;
  EXPECT_EQ(admission.judge(fitting, 1, sender), InwardVerdict::Admitted);
  EXPECT_EQ(admission.judge(fitting, 2, sender), InwardVerdict::Admitted);
  EXPECT_EQ(admission.judge(fitting, 7, sender), InwardVerdict::Admitted) << "3 to 6 were lost";
}

TEST(InwardAdmission, ASampleThatIsNotNewerHasNoEffect) {
  InwardAdmission admission;
  EXPECT_EQ(admission.judge(fitting, 5, sender), InwardVerdict::Admitted);
  EXPECT_EQ(admission.judge(fitting, 5, sender), InwardVerdict::NotNewer);
  EXPECT_EQ(admission.judge(fitting, 4, sender), InwardVerdict::NotNewer);
  EXPECT_EQ(InwardAdmission().judge(fitting, 0, sender), InwardVerdict::NotNewer)
      << "they begin at 1";
}

TEST(InwardAdmission, AnotherSessionCannotFeedTheCommand) {
  InwardAdmission admission;
  EXPECT_EQ(admission.judge({SessionId{8}, Epoch{3}, 4}, 1, sender), InwardVerdict::OtherSession);
}

TEST(InwardAdmission, ALostSessionFeedsNothing) {
  InwardAdmission admission;
  InwardSender lost = sender;
  lost.alive = false;
  EXPECT_EQ(admission.judge(fitting, 1, lost), InwardVerdict::SessionEnded);
}

TEST(InwardAdmission, AStatusThatEndedFeedsNothing) {
  InwardAdmission admission;
  for (const Epoch stale : {Epoch{2}, Epoch{4}, Epoch{0}}) {
    EXPECT_EQ(admission.judge({SessionId{9}, stale, 4}, 1, sender), InwardVerdict::OtherEpoch);
  }
}

TEST(InwardAdmission, OnlyTheRunningCommandIsFed) {
  InwardAdmission admission;
  EXPECT_EQ(admission.judge({SessionId{9}, Epoch{3}, 3}, 1, sender),
            InwardVerdict::CommandNotRunning);
  InwardSender idle = sender;
  idle.feeding.reset();
  EXPECT_EQ(admission.judge(fitting, 1, idle), InwardVerdict::CommandNotRunning);
  EXPECT_EQ(admission.judge({SessionId{9}, Epoch{3}, 0}, 1, idle), InwardVerdict::CommandNotRunning)
      << "0 is no command";
}

TEST(InwardAdmission, WithoutAStatusNoEpochFits) {
  InwardAdmission admission;
  InwardSender idle = sender;
  idle.epoch.reset();
  for (const Epoch claimed : {Epoch{3}, Epoch{0}}) {
    EXPECT_EQ(admission.judge({SessionId{9}, claimed, 4}, 1, idle), InwardVerdict::OtherEpoch);
  }
}

TEST(InwardAdmission, ASampleMayBeExactlyAsOldAsTheLimit) {
  InwardAdmission admission;
  constexpr Duration limit = std::chrono::milliseconds(48);
  EXPECT_EQ(admission.judge(fitting, 1, sender, {limit + Duration{1}, limit}),
            InwardVerdict::TooOld);
  EXPECT_EQ(admission.judge(fitting, 1, sender, {limit, limit}), InwardVerdict::Admitted);
}

TEST(InwardAdmission, ARefusedSampleDoesNotMakeLaterOnesOld) {
  InwardAdmission admission;
  EXPECT_EQ(admission.judge({SessionId{9}, Epoch{2}, 4}, ~std::uint64_t{0}, sender),
            InwardVerdict::OtherEpoch);
  EXPECT_EQ(admission.judge(fitting, 1, sender), InwardVerdict::Admitted);
}

TEST(InwardAdmission, EveryVerdictHasWords) {
  EXPECT_EQ(describe(InwardVerdict::CommandNotRunning), "its command does not run");
  EXPECT_EQ(describe(InwardVerdict{99}), "unknown");
}

}  // namespace
}  // namespace gecos::session
