// Which commands are left out after one that did not succeed, without clock, thread or packet.
#include "gecos/session/server/blend_chain.hpp"

#include <gtest/gtest.h>

#include "gecos/session/client/seen_failures.hpp"

namespace gecos::session {
namespace {

constexpr Epoch epoch{7};
const std::string called = "'move' of RX90";

BlendChain::Failed failed(std::uint64_t counter, Detail detail = Detail::Fault) {
  return {counter, "move", detail, "out of reach"};
}

TEST(BlendChain, LeavesOutWhatComesAfterAFailureAndNothingBeforeIt) {
  BlendChain chain;
  chain.arrived(3, epoch, false);
  chain.arrived(4, epoch, false);
  EXPECT_EQ(chain.first(), 3u) << "a new epoch begins a chain";
  EXPECT_FALSE(chain.left_out(3, 5, called));
  chain.broke(3, failed(4));
  EXPECT_FALSE(chain.left_out(3, 3, called));
  EXPECT_FALSE(chain.left_out(3, 4, called));
  const auto refusal = chain.left_out(3, 5, called);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->detail, Detail::Rejected);
  EXPECT_EQ(refusal->text,
            "'move' of RX90 was not carried out, because 'move', which the same caller had called "
            "before it, did not succeed: FAULT, out of reach. Look at the outcome of a failed "
            "command before you issue the next one");
}

TEST(BlendChain, EndsWithTheCallThatBeginsAnew) {
  BlendChain chain;
  chain.arrived(1, epoch, false);
  chain.broke(1, failed(2));
  chain.arrived(5, epoch, true);
  EXPECT_FALSE(chain.left_out(5, 5, called));
  EXPECT_FALSE(chain.left_out(5, 6, called));
}

TEST(BlendChain, IsNotBrokenByTheFailureOfAnEarlierChain) {
  BlendChain chain;
  chain.arrived(1, epoch, false);
  chain.arrived(5, epoch, true);
  chain.broke(1, failed(3));
  EXPECT_FALSE(chain.left_out(5, 6, called));
}

TEST(BlendChain, NamesTheEarliestFailure) {
  BlendChain chain;
  chain.arrived(1, epoch, false);
  chain.broke(1, {4, "move", Detail::QueueFull, "full"});
  chain.broke(1, {5, "move", Detail::Rejected, "left out"});
  chain.broke(1, {2, "move", Detail::Expired, "late"});
  EXPECT_NE(chain.left_out(1, 6, called)->text.find("EXPIRED, late"), std::string::npos);
}

TEST(BlendChain, BeginsAnewUnderANewerStatus) {
  BlendChain chain;
  chain.arrived(1, epoch, false);
  chain.broke(1, failed(1));
  chain.arrived(2, Epoch{8}, false);
  EXPECT_FALSE(chain.left_out(chain.first(), 2, called));
}

TEST(BlendChain, KeepsWhatACancelAndANotStartedCommandPromise) {
  for (const Detail detail : {Detail::Canceled, Detail::NotStarted}) {
    BlendChain chain;
    chain.arrived(1, epoch, false);
    chain.broke(1, failed(1, detail));
    EXPECT_EQ(chain.left_out(1, 2, called)->detail, detail);
  }
}

TEST(BlendChain, IsBrokenByACommandThatWasCanceledBeforeThoseBeforeItArrived) {
  BlendChain chain;
  chain.arrived(1, epoch, false);
  chain.broke(1, failed(4, Detail::Canceled));
  chain.arrived(2, epoch, false);
  EXPECT_FALSE(chain.left_out(1, 2, called));
  EXPECT_TRUE(chain.left_out(1, 5, called));
}

TEST(SeenFailures, LetOneCallBeginAnewForWhatTheProgramHasSeen) {
  SeenFailures failures;
  EXPECT_FALSE(failures.begins_anew());
  failures.saw(SeenFailures::of_sent(3));
  EXPECT_TRUE(failures.begins_anew());
  failures.sent_anew(6);
  EXPECT_FALSE(failures.begins_anew());
  failures.saw(SeenFailures::of_sent(5));
  EXPECT_FALSE(failures.begins_anew()) << "5 belongs to the chain that the program has left";
  failures.saw(SeenFailures::of_sent(6));
  EXPECT_TRUE(failures.begins_anew());
}

TEST(SeenFailures, KnowTheFirstCommandThatWasNotSentUntilTheProgramHasSeenIt) {
  SeenFailures failures;
  EXPECT_FALSE(failures.why_not_sent());
  failures.not_sent(SeenFailures::of_unsent(0), "full");
  failures.not_sent(SeenFailures::of_unsent(0), "left out");
  EXPECT_EQ(failures.why_not_sent(), "full");
  failures.saw(SeenFailures::of_unsent(0));
  EXPECT_FALSE(failures.why_not_sent());
  EXPECT_TRUE(failures.begins_anew());
  failures.sent_anew(1);
  EXPECT_FALSE(failures.begins_anew());
  failures.not_sent(SeenFailures::of_unsent(1), "full again");
  EXPECT_EQ(failures.why_not_sent(), "full again");
}

}  // namespace
}  // namespace gecos::session
