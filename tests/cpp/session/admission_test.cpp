#include "gecos/session/server/admission.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

constexpr SessionId ada{11};
constexpr SessionId bob{12};
constexpr TimePoint now{100s};

OperationDescription described(std::string_view name, access::Status status) {
  OperationDescription made;
  made.name = name;
  made.status = status;
  return made;
}

const OperationDescription move = described("move", access::Status::Actor);
const OperationDescription tool = described("tool", access::Status::Sensor);
const OperationDescription halt = [] {
  auto made = described("halt", access::Status::Actor);
  made.safety = true;
  return made;
}();

class AdmissionTest : public ::testing::Test {
 protected:
  AdmissionTest()
      : epoch(leases.acquire(ada, {"ada", "lab1", "grip", 7}, access::Status::Actor, {}, now)
                  ->epoch) {}

  AdmittingObject object() const { return {"RX90", leases, now}; }
  std::optional<Failure> queued(const OperationDescription& operation, SessionId client = ada) {
    return refusal_to_queue({operation, client, epoch}, object(), claim, queue, closing);
  }
  std::optional<Failure> started(const OperationDescription& operation, CallerState caller = {},
                                 bool expired = false) {
    std::optional<Failure> late;
    if (expired) late = not_in_time(operation, false);
    return refusal_to_start({operation, ada, epoch}, object(), caller, late);
  }

  access::LeaseTable leases{IncarnationId{1}, 500ms};
  const Epoch epoch;
  NameClaim claim;
  ObjectQueue queue{LaneThreads::One};
  bool closing = false;
};

TEST_F(AdmissionTest, WhoHoldsTheStatusMayQueueAndStart) {
  EXPECT_FALSE(queued(move));
  EXPECT_FALSE(started(move));
}

TEST_F(AdmissionTest, WhoDoesNotMayReadAndHaltButNotMove) {
  EXPECT_FALSE(queued(tool, bob));
  EXPECT_FALSE(queued(halt, bob));
  const auto refusal = queued(move, bob);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->detail, Detail::Denied);
  EXPECT_TRUE(refusal->text.starts_with("'move' of RX90 ")) << refusal->text;
}

TEST_F(AdmissionTest, AStatusThatEndedSinceItWasQueuedStartsNothing) {
  leases.lose(ada);
  const auto refusal = started(move);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->detail, Detail::LeaseLost);
  EXPECT_FALSE(started(tool));
  EXPECT_FALSE(started(halt));
}

TEST_F(AdmissionTest, AStopThatEndedTheStatusIsTold) {
  leases.stop(bob, "bob stopped it");
  EXPECT_EQ(started(move)->detail, Detail::Stopped);
}

TEST_F(AdmissionTest, AServerThatEndsQueuesNothingNotEvenAHalt) {
  closing = true;
  for (const auto* const operation : {&move, &tool, &halt}) {
    EXPECT_EQ(queued(*operation)->detail, Detail::Rejected) << operation->name;
  }
}

TEST_F(AdmissionTest, OnlyWhatCommandsTheObjectNeedsItsName) {
  claim.ask();
  EXPECT_FALSE(queued(move)) << "it waits in the queue until the broker has answered";
  claim.taken("another server");
  EXPECT_EQ(queued(move)->detail, Detail::NotStarted);
  EXPECT_FALSE(queued(tool));
  EXPECT_FALSE(queued(halt));
}

TEST_F(AdmissionTest, WhatRejectsOthersIsNotQueuedBesideARunningCommand) {
  auto alone = move;
  alone.on_new = OnNew::Reject;
  EXPECT_FALSE(queued(alone));
  const auto running = std::make_shared<QueueEntry>(bob, move);
  ASSERT_TRUE(queue.push(running));
  EXPECT_FALSE(queued(alone)) << "it has not started";
  ASSERT_EQ(queue.next(), running);
  const auto refusal = queued(alone);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->detail, Detail::Rejected);
  EXPECT_NE(refusal->text.find("'move' is running"), std::string::npos) << refusal->text;
  EXPECT_FALSE(queued(move)) << "it waits for its turn";
}

TEST_F(AdmissionTest, WhoseCallerIsGoneOrHasGivenItUpDoesNotStart) {
  for (const auto& caller :
       {CallerState{.gone = true}, CallerState{.withdrawn = true}, CallerState{.unheard = true}}) {
    for (const auto* const operation : {&move, &tool, &halt}) {
      const auto refusal = started(*operation, caller);
      ASSERT_TRUE(refusal) << operation->name;
      EXPECT_EQ(refusal->detail, Detail::NotStarted) << "its caller relies on it";
    }
  }
}

TEST_F(AdmissionTest, WhatIsTooLateIsExpired) {
  EXPECT_EQ(started(move, {}, true)->detail, Detail::Expired);
  EXPECT_EQ(started(halt, {}, true)->detail, Detail::Expired);
  EXPECT_EQ(started(move, {.gone = true}, true)->detail, Detail::NotStarted);
}

TEST(Expiry, IsThatMuchLaterOrNever) {
  EXPECT_EQ(expiry(3s, now), now + 3s);
  EXPECT_EQ(expiry(Duration{}, now), TimePoint::max());
  EXPECT_EQ(expiry(-1s, now), TimePoint::max());
  EXPECT_EQ(expiry(Duration::max(), now), TimePoint::max());
  EXPECT_EQ(expiry(TimePoint::max() - now, now), TimePoint::max());
  EXPECT_LT(expiry(TimePoint::max() - now - 1ns, now), TimePoint::max());
}

TEST(NotInTime, SaysWhichTermWasMissed) {
  OperationDescription turn;
  turn.name = "turn";
  turn.quality.start_by = 1500ms;
  EXPECT_EQ(not_in_time(turn, true).text,
            "'turn' did not start within its start_by of 1500 ms; the call was not carried out");
  turn.quality.start_by = 500us;
  EXPECT_EQ(not_in_time(turn, true).text,
            "'turn' did not start within its start_by of 0.5 ms; the call was not carried out");
  EXPECT_EQ(not_in_time(turn, false).text,
            "the deadline of 'turn' passed before the call started; the call was not carried out");
  EXPECT_EQ(not_in_time(turn, true).detail, Detail::Expired);
}

}  // namespace
}  // namespace gecos::session
