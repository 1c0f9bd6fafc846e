#include "gecos/access/lease_table.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;
using Commands = LeaseTable::Commands;

constexpr SessionId kAda{1};
constexpr SessionId kBob{2};
constexpr SessionId kEve{3};
const Client ada{"ada", "lab1", "grip_block", 4711};
const Client bob{"bob", "lab2", "watch", 4712};
const Proof kNoPassword;

class LeaseTableTest : public ::testing::Test {
 protected:
  bool holds(SessionId session, Status status = Status::Actor) {
    return table.may_start(session, table.epoch(), status, now).has_value();
  }
  Grant give(SessionId session, Status status, const Proof& password = kNoPassword) {
    auto grant = table.acquire(session, ada, status, password, now);
    EXPECT_TRUE(grant) << grant.error().text;
    return grant.value_or(Grant{});
  }

  TimePoint now{10s};
  LeaseTable table{IncarnationId{0x1234'5678'9abc'def0U}, 500ms};
};

TEST_F(LeaseTableTest, EverybodyMayReadWithoutALease) {
  give(kAda, Status::Actor);
  EXPECT_TRUE(table.may_queue(kBob, Epoch{}, Status::Sensor, now));
}

TEST_F(LeaseTableTest, ACommandThatArrivesAfterItsStatusWasBrokenIsDeniedWithTheReason) {
  const Grant broken = give(kAda, Status::Actor);
  table.stop(SessionId{}, "eve broke it", Denial::Reason::LeaseEnded);
  EXPECT_TRUE(table.roster().empty());
  const auto denied = table.may_queue(kAda, broken.epoch, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::LeaseEnded);
  EXPECT_NE(denied.error().text.find("eve broke it"), std::string::npos) << denied.error().text;
}

TEST_F(LeaseTableTest, MovingWithoutALeaseIsDeniedAndSaysHowToGetOne) {
  const auto denied = table.may_queue(kAda, Epoch{}, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::NeedsStatus);
  EXPECT_EQ(denied.error().text, "needs actor status; call actor(object) of gecos to acquire it");
}

TEST_F(LeaseTableTest, AHolderMayMove) {
  const Grant grant = give(kAda, Status::Actor);
  EXPECT_EQ(grant.status, Status::Actor);
  EXPECT_TRUE(table.may_queue(kAda, grant.epoch, Status::Actor, now));
  EXPECT_TRUE(table.may_start(kAda, grant.epoch, Status::Actor, now));
}

TEST_F(LeaseTableTest, AHolderStillNamesTheEpoch) {
  give(kAda, Status::Actor);
  EXPECT_FALSE(table.may_queue(kAda, Epoch{}, Status::Actor, now));
}

TEST_F(LeaseTableTest, ActorDoesNotDoWhatNeedsMaster) {
  const Grant grant = give(kAda, Status::Actor);
  const auto denied = table.may_queue(kAda, grant.epoch, Status::Master, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().text, "needs master status; call master(object) of gecos to acquire it");
}

TEST_F(LeaseTableTest, ASecondClientIsRefusedAndToldWhoHoldsItSinceAndUntilWhen) {
  give(kAda, Status::Actor);
  now += 100ms;
  const auto refused = table.acquire(kBob, bob, Status::Actor, kNoPassword, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, LeaseRefusal::Reason::HeldByOther);
  EXPECT_EQ(
      refused.error().text,
      "actor status refused: it is not shared, so wait or ask the holder to release it; actor "
      "status is held by ada on lab1 (grip_block, pid 4711) for 0.1 s; the program of ada loses "
      "the status if it stays silent for 0.4 s more");
  ASSERT_EQ(refused.error().holders.size(), 1U);
  EXPECT_EQ(refused.error().holders[0].client.pid, 4711);
}

TEST_F(LeaseTableTest, WhoIsRefusedToMoveIsToldWhoMoves) {
  const Grant grant = give(kAda, Status::Actor);
  const auto denied = table.may_queue(kBob, grant.epoch, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().text,
            "needs actor status; actor status is held by ada on lab1 (grip_block, pid 4711) "
            "for 0.0 s; the program of ada loses the status if it stays silent for 0.5 s more");
}

TEST_F(LeaseTableTest, MasterIsRefusedWhileAnotherHoldsActor) {
  give(kAda, Status::Actor);
  const auto refused = table.acquire(kBob, bob, Status::Master, kNoPassword, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, LeaseRefusal::Reason::HeldByOther);
}

TEST_F(LeaseTableTest, MasterRefusesReadingToOthersOnly) {
  const Grant grant = give(kAda, Status::Master);
  EXPECT_TRUE(table.may_queue(kAda, grant.epoch, Status::Sensor, now));
  const auto denied = table.may_queue(kBob, Epoch{}, Status::Sensor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::OthersMaster);
  EXPECT_EQ(
      denied.error().text,
      "is refused while another client is master: master status is held by ada on lab1 "
      "(grip_block, pid 4711) for 0.0 s; the program of ada loses the status if it stays silent "
      "for 0.5 s more");
}

TEST_F(LeaseTableTest, TheOnlyHolderMayBecomeMaster) {
  give(kAda, Status::Actor);
  EXPECT_EQ(give(kAda, Status::Master).status, Status::Master);
  EXPECT_EQ(give(kAda, Status::Actor).status, Status::Master);
}

TEST_F(LeaseTableTest, OneOfSeveralHoldersMayNotBecomeMaster) {
  const Proof password = plain_proof("sesame");
  give(kAda, Status::Actor, password);
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Actor, password, now));
  EXPECT_FALSE(table.acquire(kBob, bob, Status::Master, password, now));
}

TEST_F(LeaseTableTest, WhoKnowsThePasswordJoinsUnderTheSameEpoch) {
  const Proof password = plain_proof("sesame");
  const Grant first = give(kAda, Status::Actor, password);
  const auto joined = table.acquire(kBob, bob, Status::Actor, password, now);
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->epoch, first.epoch);
  EXPECT_TRUE(holds(kAda));
  EXPECT_TRUE(holds(kBob));
  EXPECT_EQ(table.roster().size(), 2U);
}

TEST_F(LeaseTableTest, WhoBringsNoPasswordIsToldThatOneIsWanted) {
  give(kAda, Status::Actor, plain_proof("sesame"));
  const auto refused = table.acquire(kBob, bob, Status::Actor, kNoPassword, now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, LeaseRefusal::Reason::WrongPassword);
  EXPECT_TRUE(
      refused.error().text.starts_with("actor status refused: it is shared by password, and no "
                                       "password was given, so ask the holder for it; actor "
                                       "status is held by ada"))
      << refused.error().text;
}

TEST_F(LeaseTableTest, AWrongPasswordIsRefusedWithoutBeingRepeated) {
  give(kAda, Status::Actor, plain_proof("sesame"));
  const auto refused = table.acquire(kBob, bob, Status::Actor, plain_proof("password1"), now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, LeaseRefusal::Reason::WrongPassword);
  EXPECT_EQ(refused.error().text.find("password1"), std::string::npos);
  EXPECT_EQ(refused.error().text.find("sesame"), std::string::npos);
}

TEST_F(LeaseTableTest, ThePasswordDoesNotOutliveTheLastMember) {
  const Proof password = plain_proof("sesame");
  const Grant grant = give(kAda, Status::Actor, password);
  table.release(kAda, grant.epoch, Commands::None);
  give(kAda, Status::Actor);
  EXPECT_FALSE(table.acquire(kBob, bob, Status::Actor, password, now));
  EXPECT_FALSE(table.acquire(kBob, bob, Status::Actor, kNoPassword, now));
}

TEST_F(LeaseTableTest, MasterCanBeSharedByPasswordToo) {
  const Proof password = plain_proof("sesame");
  give(kAda, Status::Master, password);
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Master, password, now));
  EXPECT_TRUE(holds(kBob, Status::Sensor));
  EXPECT_TRUE(holds(kBob, Status::Master));
  EXPECT_FALSE(holds(kEve, Status::Sensor));
}

TEST_F(LeaseTableTest, SilentHolderLosesTheRobot) {
  const Grant grant = give(kAda, Status::Actor);
  EXPECT_TRUE(table.expire(now + 499ms).empty());
  const auto lost = table.expire(now + 500ms);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].session, kAda);
  const auto denied = table.may_start(kAda, grant.epoch, Status::Actor, now + 500ms);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::LeaseEnded);
  EXPECT_EQ(denied.error().text,
            "was issued under a status that has ended: its holder was silent for 0.5 s; call "
            "actor(object) of gecos to acquire it again");
}

TEST_F(LeaseTableTest, ASignOfLifeKeepsTheRobot) {
  give(kAda, Status::Actor);
  table.renew(kAda, now + 400ms);
  EXPECT_TRUE(table.expire(now + 899ms).empty());
  EXPECT_EQ(table.expire(now + 900ms).size(), 1U);
}

TEST_F(LeaseTableTest, ASignOfLifeOfAnotherDoesNotKeepIt) {
  give(kAda, Status::Actor);
  table.renew(kBob, now + 400ms);
  EXPECT_EQ(table.expire(now + 500ms).size(), 1U);
}

TEST_F(LeaseTableTest, OneSilentHolderLosesItsOwnShareOnly) {
  const Proof password = plain_proof("sesame");
  const Epoch epoch = give(kAda, Status::Actor, password).epoch;
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Actor, password, now));
  table.renew(kBob, now + 400ms);
  EXPECT_EQ(table.expire(now + 500ms).size(), 1U);
  EXPECT_EQ(table.epoch(), epoch);
  EXPECT_TRUE(holds(kBob));
  EXPECT_FALSE(holds(kAda));
}

TEST_F(LeaseTableTest, ASilentHolderOfASharedStatusIsToldThatItLostItsShare) {
  const Proof password = plain_proof("sesame");
  const Epoch epoch = give(kAda, Status::Actor, password).epoch;
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Actor, password, now));
  table.renew(kBob, now + 400ms);
  ASSERT_EQ(table.expire(now + 500ms).size(), 1U);
  const auto denied = table.may_queue(kAda, epoch, Status::Actor, now + 500ms);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::LeaseEnded);
  EXPECT_EQ(
      denied.error().text,
      "was issued under a status that has ended: its holder was silent for 0.5 s; actor "
      "status is held by bob on lab2 (watch, pid 4712) for 0.5 s; the program of bob loses the "
      "status if it stays silent for 0.4 s more; call actor(object) of gecos to acquire it again");
  EXPECT_EQ(table.may_queue(kAda, Epoch{}, Status::Actor, now).error().reason,
            Denial::Reason::NeedsStatus)
      << "what is issued under no status is denied";
  ASSERT_TRUE(table.acquire(kAda, ada, Status::Actor, password, now + 500ms));
  EXPECT_TRUE(table.may_queue(kAda, epoch, Status::Actor, now + 500ms)) << "it has joined again";
}

TEST_F(LeaseTableTest, ASilentHolderOfASharedMasterStatusIsToldThatItLostItsShare) {
  const Proof password = plain_proof("sesame");
  const Epoch epoch = give(kAda, Status::Master, password).epoch;
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Master, password, now));
  table.renew(kBob, now + 400ms);
  ASSERT_EQ(table.expire(now + 500ms).size(), 1U);
  EXPECT_EQ(table.may_queue(kAda, epoch, Status::Actor, now + 500ms).error().reason,
            Denial::Reason::LeaseEnded);
}

TEST_F(LeaseTableTest, EpochRisesWhenTheObjectBecomesFree) {
  const Epoch first = give(kAda, Status::Actor).epoch;
  EXPECT_TRUE(table.release(kAda, first, Commands::None));
  EXPECT_GT(number(table.epoch()), number(first));
  EXPECT_FALSE(table.may_queue(kAda, first, Status::Actor, now));
}

TEST_F(LeaseTableTest, ReleaseDrainsBeforeAnybodyElseGetsIn) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  EXPECT_FALSE(table.release(kAda, epoch, Commands::Pending));
  EXPECT_TRUE(table.releasing(kAda));
  EXPECT_TRUE(table.may_start(kAda, epoch, Status::Actor, now)) << "what it issued still starts";
  EXPECT_FALSE(table.may_queue(kAda, epoch, Status::Actor, now)) << "nothing new is taken";
  EXPECT_TRUE(table.may_queue(kAda, epoch, Status::Sensor, now));
  const auto refused = table.acquire(kBob, bob, Status::Actor, kNoPassword, now);
  ASSERT_FALSE(refused);
  EXPECT_NE(
      refused.error().text.find("the status is released, but the last commands under it still run"),
      std::string::npos);
  table.drained(kAda);
  EXPECT_TRUE(table.acquire(kBob, bob, Status::Actor, kNoPassword, now));
}

TEST_F(LeaseTableTest, AProgramThatEndsWhileItDrainsStillLiftsItsBlock) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  table.release(kAda, epoch, Commands::Pending);
  EXPECT_FALSE(table.lose(kAda));
  EXPECT_TRUE(table.expire(now + 1h).empty());
  EXPECT_TRUE(table.may_start(kAda, epoch, Status::Actor, now + 1h));
}

TEST_F(LeaseTableTest, AReleasingHolderThatAcquiresAgainGoesOn) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  table.release(kAda, epoch, Commands::Pending);
  EXPECT_EQ(give(kAda, Status::Actor).epoch, epoch);
  EXPECT_FALSE(table.releasing(kAda));
  table.drained(kAda);
  EXPECT_TRUE(holds(kAda));
  EXPECT_TRUE(table.release(kAda, epoch, Commands::None));
}

TEST_F(LeaseTableTest, AcquiredTwiceIsReleasedTwice) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  give(kAda, Status::Actor);
  EXPECT_FALSE(table.release(kAda, epoch, Commands::None));
  EXPECT_TRUE(holds(kAda));
  EXPECT_TRUE(table.release(kAda, epoch, Commands::None));
  EXPECT_FALSE(holds(kAda));
}

TEST_F(LeaseTableTest, AStaleReleaseChangesNothing) {
  const Epoch stale = give(kAda, Status::Actor).epoch;
  table.stop(kBob, "stopped by eve");
  give(kAda, Status::Actor);
  EXPECT_FALSE(table.release(kAda, stale, Commands::None));
  EXPECT_TRUE(holds(kAda));
}

TEST_F(LeaseTableTest, ALostHolderIsGoneAtOnce) {
  give(kAda, Status::Actor);
  EXPECT_TRUE(table.lose(kAda));
  EXPECT_FALSE(table.lose(kAda));
  EXPECT_TRUE(table.acquire(kBob, bob, Status::Actor, kNoPassword, now));
}

TEST_F(LeaseTableTest, StopEndsEveryLeaseAndNothingOfThemStarts) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  const auto ended = table.stop(kBob, "stopped by eve");
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].session, kAda);
  EXPECT_FALSE(table.may_start(kAda, epoch, Status::Actor, now));
  EXPECT_TRUE(table.acquire(kBob, bob, Status::Actor, kNoPassword, now)) << "there is no reset";
}

TEST_F(LeaseTableTest, WhatArrivesAfterTheStopThatEndedItsStatusIsStopped) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  table.stop(kBob, "stopped by bob on lab2");
  const auto denied = table.may_queue(kAda, epoch, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::Stopped);
  EXPECT_EQ(denied.error().text,
            "was issued under a status that has ended: stopped by bob on lab2; call actor(object) "
            "of gecos to acquire it again");
  const Epoch later = give(kAda, Status::Actor).epoch;
  EXPECT_EQ(table.may_queue(kAda, epoch, Status::Actor, now).error().reason,
            Denial::Reason::Stopped)
      << "it does not start under the next status either";
  table.expire(now + 500ms);
  EXPECT_EQ(table.may_queue(kAda, later, Status::Actor, now).error().reason,
            Denial::Reason::LeaseEnded)
      << "what silence ended no stop ended";
}

TEST_F(LeaseTableTest, StopByAMemberKeepsItsOwnUnderTheNewEpoch) {
  const Proof password = plain_proof("sesame");
  const Epoch epoch = give(kAda, Status::Actor, password).epoch;
  ASSERT_TRUE(table.acquire(kBob, bob, Status::Actor, password, now));
  EXPECT_EQ(table.stop(kAda, "stopped by eve").size(), 1U);
  EXPECT_GT(number(table.epoch()), number(epoch));
  EXPECT_FALSE(table.may_start(kAda, epoch, Status::Actor, now)) << "issued before the stop";
  EXPECT_TRUE(holds(kAda));
  EXPECT_FALSE(holds(kBob));
}

TEST_F(LeaseTableTest, StopEndsDrainingToo) {
  const Epoch epoch = give(kAda, Status::Actor).epoch;
  table.release(kAda, epoch, Commands::Pending);
  EXPECT_EQ(table.stop(kAda, "stopped by eve").size(), 1U);
  EXPECT_FALSE(table.may_start(kAda, epoch, Status::Actor, now));
}

TEST_F(LeaseTableTest, StopOfAFreeObjectStillFencesWhatWasIssuedBefore) {
  const Epoch epoch = table.epoch();
  EXPECT_TRUE(table.stop(kBob, "stopped by eve").empty());
  EXPECT_NE(table.epoch(), epoch);
}

class TakeOverTest : public LeaseTableTest {
 protected:
  void SetUp() override {
    epoch = give(kAda, Status::Actor, password).epoch;
    ASSERT_TRUE(table.acquire(kBob, bob, Status::Actor, password, now));
    ASSERT_TRUE(table.take_over(kBob, now));
    now += 100ms;
  }
  Denial::Reason refused(SessionId session, Epoch under) {
    const auto may = table.may_queue(session, under, Status::Actor, now);
    EXPECT_FALSE(may);
    const auto start = table.may_start(session, under, Status::Actor, now);
    EXPECT_FALSE(start);
    return may ? Denial::Reason::NeedsStatus : may.error().reason;
  }

  const Proof password = plain_proof("sesame");
  Epoch epoch{};
};

TEST_F(TakeOverTest, HoldsOffTheOthersAndTellsThemWho) {
  EXPECT_TRUE(holds(kBob));
  const auto denied = table.may_queue(kAda, table.epoch(), Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::HeldOff);
  EXPECT_EQ(denied.error().text,
            "is held off: bob on lab2 (watch, pid 4712) took over 0.1 s ago; wait until it gives "
            "sole command back");
  EXPECT_TRUE(table.may_queue(kAda, table.epoch(), Status::Sensor, now)) << "reading goes on";
}

TEST_F(TakeOverTest, FencesWhatWasIssuedBeforeEvenWhenItArrivesAfterTheEnd) {
  auto denied = table.may_queue(kAda, epoch, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::Preempted);
  EXPECT_EQ(denied.error().text,
            "was issued before bob on lab2 (watch, pid 4712) took over, 0.1 s ago; wait until it "
            "gives sole command back");
  table.give_back(kBob);
  denied = table.may_queue(kAda, epoch, Status::Actor, now);
  ASSERT_FALSE(denied);
  EXPECT_EQ(denied.error().reason, Denial::Reason::Preempted);
  EXPECT_EQ(denied.error().text,
            "was issued before bob on lab2 (watch, pid 4712) took over, 0.1 s ago; check where the "
            "device is, and command again");
  EXPECT_TRUE(holds(kAda)) << "what it issues now starts";
}

TEST_F(TakeOverTest, KeepsWhatTheTakerIssuedBefore) {
  EXPECT_GT(table.epoch(), epoch);
  EXPECT_TRUE(table.may_start(kBob, epoch, Status::Actor, now));
}

TEST_F(TakeOverTest, ByASecondHolderIsRefusedWithTheNameOfTheTaker) {
  const auto refused = table.take_over(kAda, now);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(
      refused.error().text.starts_with("take-over refused: bob on lab2 (watch, pid 4712) has taken "
                                       "over; wait until it gives sole command back, "
                                       "or stop the object; actor status is held by "))
      << refused.error().text;
  EXPECT_NE(refused.error().text.find("; the program of bob took over 0.1 s ago; "),
            std::string::npos);
  const Epoch before = table.epoch();
  EXPECT_TRUE(table.take_over(kBob, now)) << "the taker has it already";
  EXPECT_EQ(table.epoch(), before);
}

TEST_F(TakeOverTest, IsForHoldersOnly) {
  table.give_back(kBob);
  const auto refused = table.take_over(kEve, now);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().text.starts_with(
      "take-over refused: this client does not hold the status; acquire it first; actor status"))
      << refused.error().text;
  table.release(kBob, table.epoch(), Commands::Pending);
  EXPECT_FALSE(table.take_over(kBob, now)) << "it has released the status";
}

TEST_F(TakeOverTest, IsGivenBackByTheTakerOnly) {
  EXPECT_FALSE(table.give_back(kAda));
  EXPECT_FALSE(holds(kAda));
  EXPECT_TRUE(table.give_back(kBob));
  EXPECT_TRUE(holds(kAda));
  EXPECT_FALSE(table.give_back(kBob));
  ASSERT_TRUE(table.take_over(kAda, now)) << "another holder can take over then";
  EXPECT_FALSE(holds(kBob));
}

TEST_F(TakeOverTest, HoldsOffAHolderThatJoinsLater) {
  ASSERT_TRUE(table.acquire(kEve, ada, Status::Actor, password, now));
  EXPECT_EQ(refused(kEve, table.epoch()), Denial::Reason::HeldOff);
  table.give_back(kBob);
  EXPECT_TRUE(holds(kEve));
}

TEST_F(TakeOverTest, EndsWhenTheTakerIsLost) {
  EXPECT_TRUE(table.lose(kBob));
  EXPECT_TRUE(holds(kAda));
  EXPECT_EQ(refused(kAda, epoch), Denial::Reason::Preempted) << "nothing resumes";
}

TEST_F(TakeOverTest, EndsWhenTheTakerIsSilent) {
  table.renew(kAda, now + 400ms);
  ASSERT_EQ(table.expire(now + 400ms).size(), 1U);
  EXPECT_TRUE(holds(kAda));
}

TEST_F(TakeOverTest, LastsUntilTheLastCommandOfATakerThatReleasesHasEnded) {
  table.release(kBob, table.epoch(), Commands::Pending);
  EXPECT_EQ(refused(kAda, table.epoch()), Denial::Reason::HeldOff);
  table.drained(kBob);
  EXPECT_TRUE(holds(kAda));
}

TEST_F(TakeOverTest, IsKeptByATakerThatStops) {
  table.stop(kBob, "stopped by bob");
  ASSERT_TRUE(table.acquire(kAda, ada, Status::Actor, password, now));
  EXPECT_EQ(refused(kAda, table.epoch()), Denial::Reason::HeldOff);
  EXPECT_TRUE(holds(kBob));
}

TEST_F(TakeOverTest, EndsWhenAnotherClientStops) {
  table.stop(kAda, "stopped by ada");
  EXPECT_TRUE(holds(kAda));
  EXPECT_FALSE(holds(kBob));
}

TEST_F(TakeOverTest, OfAStatusThatAStopEndedIsToldAsTheStop) {
  const Epoch taken = table.epoch();
  table.stop(kEve, "stopped by eve");
  for (const Epoch issued : {epoch, taken}) {
    EXPECT_EQ(refused(kBob, issued), Denial::Reason::Stopped);
    EXPECT_EQ(refused(kAda, issued), Denial::Reason::Stopped);
  }
}

TEST_F(TakeOverTest, IsShownAmongTheHolders) {
  const auto holders = table.roster();
  ASSERT_EQ(holders.size(), 2U);
  EXPECT_EQ(holders[1].session, kBob);
  EXPECT_TRUE(holders[1].taken_over);
  EXPECT_EQ(holders[1].taken_over_since, now - 100ms);
  EXPECT_FALSE(holders[0].taken_over);
  table.give_back(kBob);
  EXPECT_FALSE(table.roster()[1].taken_over);
}

TEST_F(LeaseTableTest, EpochsOfTwoServerLivesDiffer) {
  const LeaseTable restarted{IncarnationId{0x0fed'cba9'8765'4321U}, 500ms};
  EXPECT_NE(restarted.epoch(), table.epoch());
  EXPECT_NE(table.epoch(), Epoch{});
}

TEST(Status, IsNamedAsPeopleSayIt) {
  EXPECT_EQ(to_string(Status::Sensor), "sensor");
  EXPECT_EQ(to_string(Status::Actor), "actor");
  EXPECT_EQ(to_string(Status::Master), "master");
}

}  // namespace
}  // namespace gecos::access
