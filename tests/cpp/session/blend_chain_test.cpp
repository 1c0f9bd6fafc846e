// Which commands are left out after one that did not succeed, without clock, thread or packet.
#include "gecos/session/server/blend_chain.hpp"

#include <gtest/gtest.h>

#include "gecos/session/client/seen_failures.hpp"

namespace gecos::session {
namespace {

using Known = ChainReport::Known;

constexpr std::uint64_t held = 7;
const std::string called = "'move' of RX90";

BlendChain::Failed failed(std::uint64_t counter, Detail detail = Detail::Fault) {
  return {counter, "move", detail, "out of reach"};
}

class BlendChainTest : public ::testing::Test {
 protected:
  void arrived(std::uint64_t counter, std::vector<ChainReport::Entry> known = {}) {
    chain_.arrived({counter, held, false}, {std::move(known)});
  }
  bool left_out(std::uint64_t counter) const {
    return chain_.left_out(counter, called).has_value();
  }

  BlendChain chain_;
};

TEST_F(BlendChainTest, LeavesOutWhatComesAfterAFailureAndNothingBeforeIt) {
  arrived(3);
  arrived(4);
  EXPECT_FALSE(left_out(5));
  chain_.failed(failed(4));
  EXPECT_FALSE(left_out(3));
  EXPECT_FALSE(left_out(4));
  const auto refusal = chain_.left_out(5, called);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->because_of, 4u);
  EXPECT_EQ(refusal->failure.detail, Detail::Rejected);
  EXPECT_EQ(refusal->failure.text,
            "'move' of RX90 was not carried out, because the earlier command 'move' of the same "
            "caller did not succeed: FAULT, out of reach. Look at the outcome of a failed command "
            "before you issue the next one");
}

TEST_F(BlendChainTest, CarriesOutWhatItsProgramIssuedWhenItKnewTheFailure) {
  arrived(1);
  arrived(2);
  chain_.failed(failed(2));
  arrived(5, {{2, Known::Failure}});
  EXPECT_TRUE(left_out(4)) << "issued before";
  EXPECT_FALSE(left_out(5));
  EXPECT_FALSE(left_out(6));
}

TEST_F(BlendChainTest, LeavesOutWhatItsProgramIssuedWhenItKnewOnlyAnotherFailure) {
  arrived(1);
  arrived(2);
  chain_.failed(failed(2));
  arrived(5, {{2, Known::Failure}});
  chain_.failed(failed(1));
  EXPECT_TRUE(left_out(5)) << "1 still ran when the program saw the failure of 2";
  EXPECT_TRUE(left_out(6));
  arrived(7, {{1, Known::Failure}});
  EXPECT_FALSE(left_out(7));
}

TEST_F(BlendChainTest, GoesOnWhenTheFirstOfTwoFailuresIsKnownInWhicheverOrderTheyCame) {
  for (const bool later_first : {false, true}) {
    chain_ = {};
    arrived(1);
    chain_.failed(failed(later_first ? 4 : 2));
    chain_.failed(failed(later_first ? 2 : 4));
    EXPECT_EQ(chain_.left_out(5, called)->because_of, 2u);
    arrived(6, {{2, Known::Failure}});
    EXPECT_FALSE(left_out(6)) << "4 would have been left out because of 2";
  }
}

TEST_F(BlendChainTest, CarriesOutWhatWasIssuedAfterACancel) {
  for (const Detail end : {Detail::Canceled, Detail::TimedOut}) {
    chain_ = {};
    arrived(1);
    arrived(5, {{1, Known::Canceled}});
    chain_.failed(failed(1, end));
    EXPECT_TRUE(left_out(4)) << "issued before the cancel";
    EXPECT_FALSE(left_out(5));
  }
}

TEST_F(BlendChainTest, LeavesOutWhatWasIssuedAfterACancelOfACommandThatFailed) {
  arrived(1);
  arrived(5, {{1, Known::Canceled}});
  chain_.failed(failed(1));
  EXPECT_TRUE(left_out(5)) << "a fault is not the end for which the program asked";
}

TEST_F(BlendChainTest, LeavesOutWhatWasIssuedAfterACancelIfTheCanceledCommandThenFails) {
  arrived(1);
  chain_.failed(failed(1, Detail::Canceled));  // while it runs
  arrived(5, {{1, Known::Canceled}});
  EXPECT_FALSE(left_out(5));
  chain_.failed(failed(1));
  EXPECT_TRUE(left_out(5));
}

TEST_F(BlendChainTest, IsNotFreedByTheCancelOfACommandThatWasLeftOut) {
  arrived(1);
  arrived(2);
  chain_.failed(failed(1));
  arrived(3, {{2, Known::Canceled}});
  EXPECT_TRUE(left_out(3)) << "the program has not seen the failure of 1";
}

TEST_F(BlendChainTest, IgnoresTheFailureOfADetachedCommandAndOfNoOther) {
  arrived(1);
  arrived(2);
  arrived(3, {{1, Known::Detached}});
  chain_.failed(failed(1));
  EXPECT_FALSE(left_out(3));
  chain_.failed(failed(2));
  EXPECT_TRUE(left_out(3));
}

TEST_F(BlendChainTest, ForgetsWhatItsProgramKnewOfACommandThatSucceeded) {
  arrived(1);
  for (std::uint64_t counter = 2; counter < 2000; ++counter) {
    arrived(counter + 1, {{counter, Known::Detached}, {1, Known::Detached}});
    chain_.succeeded(counter);
  }
  chain_.failed(failed(1));
  EXPECT_FALSE(left_out(2001)) << "1 was not pushed out";
}

TEST_F(BlendChainTest, NamesTheEarliestFailure) {
  for (const std::uint64_t counter : {1, 2, 3, 4, 5}) arrived(counter);
  chain_.failed({4, "move", Detail::QueueFull, "full"});
  chain_.failed({5, "move", Detail::Rejected, "left out"});
  chain_.failed({2, "move", Detail::Expired, "late"});
  EXPECT_NE(chain_.left_out(6, called)->failure.text.find("EXPIRED, late"), std::string::npos);
}

TEST_F(BlendChainTest, BeginsAnewUnderANewerStatus) {
  arrived(1);
  chain_.failed(failed(1));
  chain_.arrived({2, held + 1, false}, {});
  EXPECT_FALSE(left_out(2));
  chain_.arrived({3, 0, false}, {});  // of the earlier status, late
  chain_.arrived({4, held + 1, false}, {});
  chain_.failed(failed(3));
  EXPECT_TRUE(left_out(4)) << "the same status once more begins nothing";
}

TEST_F(BlendChainTest, BeginsAnewWithACommandThatStandsAlone) {
  arrived(1);
  arrived(2);
  chain_.failed(failed(1));
  chain_.arrived({3, held, true}, {});
  EXPECT_FALSE(left_out(3));
  chain_.failed(failed(2, Detail::Stopped));
  EXPECT_FALSE(left_out(3)) << "it was asked for before the stop";
  EXPECT_FALSE(left_out(4));
  chain_.failed(failed(3));
  EXPECT_TRUE(left_out(4));
}

TEST_F(BlendChainTest, KeepsWhatACancelAndANotStartedCommandPromise) {
  for (const Detail detail : {Detail::Canceled, Detail::NotStarted}) {
    chain_ = {};
    arrived(1);
    chain_.failed(failed(1, detail));
    EXPECT_EQ(chain_.left_out(2, called)->failure.detail, detail);
  }
}

TEST_F(BlendChainTest, IsBrokenByCommandsThatWereCanceledBeforeThoseBeforeThemArrived) {
  arrived(1);
  chain_.failed(failed(6, Detail::Canceled));
  chain_.failed(failed(4, Detail::Canceled));
  arrived(2);
  EXPECT_FALSE(left_out(2));
  arrived(5, {{4, Known::Canceled}});
  EXPECT_FALSE(left_out(5));
  EXPECT_TRUE(left_out(8)) << "issued before the cancel of 6";
}

TEST_F(BlendChainTest, IgnoresADetachedCommandThatWasCanceledBeforeAndThenFailed) {
  arrived(1);
  chain_.failed(failed(1, Detail::Canceled));
  arrived(2, {{1, Known::Canceled}});
  arrived(3, {{1, Known::Detached}});
  chain_.failed(failed(1));
  EXPECT_TRUE(left_out(2));
  EXPECT_FALSE(left_out(3));
}

TEST_F(BlendChainTest, StaysSmallWhateverAClientSends) {
  arrived(1);
  chain_.failed(failed(1));
  for (std::uint64_t counter = 2; counter < 100'000; ++counter) {
    arrived(counter, {{counter + 1'000'000, Known::Detached}});
    chain_.failed(failed(counter));
    ASSERT_EQ(chain_.left_out(counter + 1, called)->because_of, 1u);
  }
  for (std::uint64_t counter = 200'000; counter > 100'000; --counter) {
    chain_.failed(failed(counter));
    ASSERT_EQ(chain_.left_out(300'000, called)->because_of, 1u);
  }
}

TEST(SeenFailures, AreReportedOnceWithTheNextCommand) {
  SeenFailures failures;
  EXPECT_EQ(failures.next().flags, 0);
  failures.knows({true, 3}, Known::Failure);
  failures.knows({true, 3}, Known::Failure);
  failures.knows({true, 5}, Known::Canceled);
  const auto says = failures.next();
  EXPECT_EQ(says.flags, reports);
  EXPECT_EQ(says.report.entries,
            (std::vector<ChainReport::Entry>{{3, Known::Failure}, {5, Known::Canceled}}));
  EXPECT_EQ(failures.next().report.entries.size(), 2u) << "it was not sent";
  failures.sent(says);
  EXPECT_EQ(failures.next().flags, 0);
}

TEST(SeenFailures, LetACallStandAloneAfterAStop) {
  SeenFailures failures;
  failures.begins_alone();
  const auto says = failures.next();
  EXPECT_EQ(says.flags, stands_alone);
  failures.sent(says);
  EXPECT_EQ(failures.next().flags, 0);
}

TEST(SeenFailures, KnowTheFirstCommandThatWasNotSentUntilTheProgramHasSeenIt) {
  SeenFailures failures;
  EXPECT_FALSE(failures.why_not_sent());
  const auto full = failures.not_sent("full");
  failures.not_sent("left out");
  EXPECT_EQ(failures.why_not_sent(), "full");
  failures.knows(full, Known::Failure);
  EXPECT_FALSE(failures.why_not_sent());
  EXPECT_EQ(failures.next().flags, 0) << "the program has not seen how those ended that were sent";
  failures.not_sent("full again");
  EXPECT_EQ(failures.why_not_sent(), "full again");
}

TEST(SeenFailures, AreAllSeenWithANewStatusAndNotWithTheSameOnceMore) {
  SeenFailures failures;
  failures.acquired(7);
  failures.not_sent("full");
  failures.acquired(7);
  EXPECT_EQ(failures.why_not_sent(), "full");
  EXPECT_EQ(failures.next().flags, 0);
  failures.acquired(9);
  EXPECT_FALSE(failures.why_not_sent());
}

TEST(ChainReport, IsReadAsItWasWritten) {
  const ChainReport report{{{3, Known::Failure}, {1ULL << 60, Known::Detached}}};
  Bytes bytes(report.encoded_size());
  wire::Encoder to(bytes);
  report.encode(to);
  ChainReport read;
  wire::Decoder from(bytes);
  ASSERT_TRUE(read.decode(from));
  EXPECT_EQ(read.entries, report.entries);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    wire::Decoder cut(ByteView(bytes).first(size));
    EXPECT_FALSE(ChainReport().decode(cut)) << size;
  }
}

}  // namespace
}  // namespace gecos::session
