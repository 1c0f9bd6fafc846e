#include "gecos/session/server/name_claim.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using Standing = NameClaim::Standing;

/// The claim of an object whose server has asked the broker.
struct Asked : NameClaim {
  Asked() { ask(); }
};

TEST(NameClaim, OfAnObjectThatNobodyElseFindsNeedsNoAnswer) {
  NameClaim claim;
  EXPECT_FALSE(claim.waits());
  EXPECT_FALSE(claim.refuses());
  EXPECT_FALSE(claim.unanswered(claim.question(), "no broker answers"));
  EXPECT_FALSE(claim.refuses());
}

TEST(NameClaim, WaitsUntilItIsConfirmed) {
  Asked claim;
  EXPECT_TRUE(claim.waits());
  EXPECT_TRUE(claim.held(claim.question()));
  EXPECT_FALSE(claim.waits());
  EXPECT_FALSE(claim.refuses());
  EXPECT_FALSE(claim.held(claim.question())) << "no news";
}

TEST(NameClaim, AnAnswerFromBeforeAPauseDoesNotConfirmIt) {
  Asked claim;
  const auto before = claim.question();
  claim.ask();
  EXPECT_FALSE(claim.held(before));
  EXPECT_TRUE(claim.waits());
  EXPECT_FALSE(claim.unanswered(before, "the broker did not answer in time"));
  EXPECT_TRUE(claim.waits());
}

TEST(NameClaim, IsNotOpenedByABrokerThatMayStillGiveTheNameAway) {
  Asked claim;
  EXPECT_FALSE(claim.provisional());
  EXPECT_TRUE(claim.waits());
  ASSERT_TRUE(claim.unanswered(claim.question(), "no broker answers"));
  EXPECT_TRUE(claim.refuses());
  EXPECT_TRUE(claim.provisional()) << "one answers: commands may wait again";
  EXPECT_TRUE(claim.waits());
}

TEST(NameClaim, RefusesWhileNoBrokerAnswersAndSaysWhy) {
  Asked claim;
  EXPECT_TRUE(claim.unanswered(claim.question(), "no broker answers"));
  EXPECT_TRUE(claim.refuses());
  EXPECT_NE(claim.text().find("(no broker answers); the server goes on asking"), std::string::npos);
  EXPECT_FALSE(claim.unanswered(claim.question(), "no broker answers")) << "no news";
  EXPECT_TRUE(claim.held(claim.question()));
  EXPECT_FALSE(claim.refuses());
}

TEST(NameClaim, TheDeathOfABrokerWithoutAPauseChangesNothing) {
  Asked claim;
  claim.held(claim.question());
  EXPECT_FALSE(claim.unanswered(claim.question(), "no broker answers"));
  EXPECT_FALSE(claim.provisional());
  EXPECT_EQ(claim.standing(), Standing::Held);
}

TEST(NameClaim, IsLostWheneverABrokerSaysSoAndComesBackOnlyByAnAnswer) {
  Asked claim;
  claim.held(claim.question());
  EXPECT_TRUE(claim.taken("a robcl::Rx90 of ada on lab1, pid 4711"));
  EXPECT_FALSE(claim.taken("a robcl::Rx90 of ada on lab1, pid 4711")) << "no news";
  EXPECT_TRUE(claim.refuses());
  EXPECT_NE(claim.text().find("pid 4711"), std::string::npos);
  claim.ask();
  EXPECT_EQ(claim.standing(), Standing::Taken) << "a pause does not give it back";
  EXPECT_FALSE(claim.unanswered(claim.question(), "no broker answers"));
  EXPECT_TRUE(claim.held(claim.question()));
  EXPECT_FALSE(claim.refuses());
}

}  // namespace
}  // namespace gecos::session
