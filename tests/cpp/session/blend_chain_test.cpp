// Which commands are left out after one that did not succeed, without clock, thread or packet.
#include "gecos/session/server/blend_chain.hpp"

#include <gtest/gtest.h>

#include "gecos/session/client/seen_failures.hpp"

namespace gecos::session {
namespace {

using Begin = BlendChain::Begin;

constexpr std::uint64_t held = 7;
const std::string called = "'move' of RX90";

BlendChain::Failed failed(std::uint64_t counter, Detail detail = Detail::Fault) {
  return {counter, "move", detail, "out of reach"};
}

TEST(BlendChain, LeavesOutWhatComesAfterAFailureAndNothingBeforeIt) {
  BlendChain chain;
  chain.arrived(3, held, Begin::No);
  chain.arrived(4, held, Begin::No);
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
  chain.arrived(1, held, Begin::No);
  chain.broke(1, failed(2));
  chain.arrived(5, held, Begin::Anew);
  EXPECT_FALSE(chain.left_out(5, 5, called));
  EXPECT_FALSE(chain.left_out(5, 6, called));
}

TEST(BlendChain, IsBoundByTheCommandsOfEarlierChainsThatAreOpen) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  chain.broke(chain.first(), failed(2));
  chain.arrived(5, held, Begin::Anew);
  EXPECT_FALSE(chain.left_out(5, 6, called)) << "the program has seen the failure of 2";
  chain.broke(1, failed(1));
  EXPECT_TRUE(chain.left_out(5, 5, called)) << "1 ran when the program began anew";
  EXPECT_TRUE(chain.left_out(5, 6, called));
}

TEST(BlendChain, IsNotBoundByWhatItsProgramCanceled) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  chain.arrived(5, held, Begin::Anew);
  chain.broke(1, failed(1, Detail::Canceled));
  EXPECT_FALSE(chain.left_out(5, 5, called));
}

TEST(BlendChain, ThatStandsAloneIsBoundByNothingEarlier) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  const std::uint64_t first = chain.first();
  chain.arrived(5, held, Begin::Alone);
  chain.broke(first, failed(1));
  EXPECT_FALSE(chain.left_out(5, 6, called));
  chain.arrived(7, held, Begin::Anew);
  chain.broke(first, failed(2));
  EXPECT_FALSE(chain.left_out(7, 8, called));
  chain.broke(5, failed(6));
  EXPECT_TRUE(chain.left_out(7, 8, called));
}

TEST(BlendChain, NamesTheEarliestFailure) {
  BlendChain chain;
  for (const std::uint64_t counter : {1, 2, 3, 4, 5}) chain.arrived(counter, held, Begin::No);
  chain.broke(1, {4, "move", Detail::QueueFull, "full"});
  chain.broke(1, {5, "move", Detail::Rejected, "left out"});
  chain.broke(1, {2, "move", Detail::Expired, "late"});
  EXPECT_NE(chain.left_out(1, 6, called)->text.find("EXPIRED, late"), std::string::npos);
}

TEST(BlendChain, BeginsAnewUnderANewerStatus) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  chain.broke(1, failed(1));
  chain.arrived(2, held + 1, Begin::No);
  EXPECT_FALSE(chain.left_out(chain.first(), 2, called));
}

TEST(BlendChain, KeepsWhatACancelAndANotStartedCommandPromise) {
  for (const Detail detail : {Detail::Canceled, Detail::NotStarted}) {
    BlendChain chain;
    chain.arrived(1, held, Begin::No);
    chain.broke(1, failed(1, detail));
    EXPECT_EQ(chain.left_out(1, 2, called)->detail, detail);
  }
}

TEST(BlendChain, IsBrokenByACommandThatWasCanceledBeforeThoseBeforeItArrived) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  chain.broke(1, failed(4, Detail::Canceled));
  chain.arrived(2, held, Begin::No);
  EXPECT_FALSE(chain.left_out(1, 2, called));
  EXPECT_TRUE(chain.left_out(1, 5, called));
}

TEST(BlendChain, KeepsTheFailureOfACommandThatWasCanceledInAdvanceWhenAnotherChainBegins) {
  BlendChain chain;
  chain.arrived(1, held, Begin::No);
  chain.arrived(2, held, Begin::No);
  chain.broke(chain.first(), failed(2));
  chain.broke(chain.first(), failed(4, Detail::Canceled));  // before 3 arrives
  chain.arrived(3, held, Begin::Anew);
  EXPECT_FALSE(chain.left_out(3, 3, called));
  chain.arrived(5, held, Begin::No);
  EXPECT_TRUE(chain.left_out(3, 5, called));
}

TEST(SeenFailures, LetOneCallBeginAnewForWhatTheProgramHasSeen) {
  SeenFailures failures;
  EXPECT_EQ(failures.flags(), 0);
  failures.saw({true, 3});
  EXPECT_EQ(failures.flags(), begins_anew);
  failures.sent(6, begins_anew);
  EXPECT_EQ(failures.flags(), 0);
  failures.saw({true, 5});
  EXPECT_EQ(failures.flags(), 0) << "5 belongs to the chain that the program has left";
  failures.saw({true, 6});
  EXPECT_EQ(failures.flags(), begins_anew);
}

TEST(SeenFailures, LetACallStandAloneAfterADetachedCommand) {
  SeenFailures failures;
  failures.ignores({true, 3});
  EXPECT_EQ(failures.flags(), stands_alone);
  failures.sent(4, stands_alone);
  EXPECT_EQ(failures.flags(), 0);
}

TEST(SeenFailures, KnowTheFirstCommandThatWasNotSentUntilTheProgramHasSeenIt) {
  SeenFailures failures;
  EXPECT_FALSE(failures.why_not_sent());
  const auto full = failures.not_sent("full");
  failures.not_sent("left out");
  EXPECT_EQ(failures.why_not_sent(), "full");
  failures.saw(full);
  EXPECT_FALSE(failures.why_not_sent());
  EXPECT_EQ(failures.flags(), 0) << "the program has not seen how those ended that were sent";
  failures.not_sent("full again");
  EXPECT_EQ(failures.why_not_sent(), "full again");
}

TEST(SeenFailures, AreAllSeenWithANewStatusAndNotWithTheSameOnceMore) {
  SeenFailures failures;
  failures.acquired(7);
  failures.not_sent("full");
  failures.acquired(7);
  EXPECT_EQ(failures.why_not_sent(), "full");
  EXPECT_EQ(failures.flags(), 0);
  failures.acquired(9);
  EXPECT_FALSE(failures.why_not_sent());
}

}  // namespace
}  // namespace gecos::session
