#include "gecos/session/server/object_queue.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

constexpr SessionId ada{1};
constexpr SessionId bob{2};

OperationDescription operation(access::Status status) {
  OperationDescription made;
  made.status = status;
  return made;
}

const OperationDescription moves = operation(access::Status::Actor);
const OperationDescription reads = operation(access::Status::Sensor);

std::shared_ptr<QueueEntry> entry(const OperationDescription& which, SessionId client = ada) {
  return std::make_shared<QueueEntry>(client, which);
}

void finish(ObjectQueue& queue, const QueueEntry& done) {
  queue.returned(done);
  queue.ended(done);
}

TEST(ObjectQueue, StartsActorCommandsOneAtATimeInTheirOrder) {
  ObjectQueue queue(LaneThreads::Many);
  const auto first = entry(moves);
  const auto second = entry(moves, bob);
  ASSERT_TRUE(queue.push(first));
  ASSERT_TRUE(queue.push(second));
  EXPECT_EQ(queue.next(), first);
  EXPECT_EQ(queue.next(), nullptr);
  EXPECT_EQ(queue.position(*second), 1u);
  finish(queue, *first);
  EXPECT_EQ(queue.next(), second);
}

TEST(ObjectQueue, StartsABlendBesideOneThatLetsIt) {
  OperationDescription blends = moves;
  blends.on_new = OnNew::Blend;
  ObjectQueue queue(LaneThreads::Many);
  const auto first = entry(blends), second = entry(blends), third = entry(moves);
  for (const auto& each : {first, second, third}) ASSERT_TRUE(queue.push(each));
  ASSERT_EQ(queue.next(), first);
  EXPECT_EQ(queue.next(), nullptr) << "the first one has not let it";
  first->lets_next = true;
  EXPECT_EQ(queue.next(), second);
  second->lets_next = true;
  EXPECT_EQ(queue.next(), nullptr) << "the third one does not blend";
  finish(queue, *first);
  EXPECT_EQ(queue.next(), nullptr);
  finish(queue, *second);
  EXPECT_EQ(queue.next(), third);
}

TEST(ObjectQueue, KeepsTheLaneUntilTheAnswerThoughTheHandlerReturned) {
  ObjectQueue queue(LaneThreads::One);
  const auto first = entry(moves);
  const auto second = entry(moves);
  ASSERT_TRUE(queue.push(first));
  ASSERT_TRUE(queue.push(second));
  ASSERT_EQ(queue.next(), first);
  queue.returned(*first);
  EXPECT_EQ(queue.next(), nullptr);
  queue.ended(*first);
  EXPECT_EQ(queue.next(), second);
}

TEST(ObjectQueue, LetsReadingOvertakeAMotion) {
  ObjectQueue queue(LaneThreads::Many);
  const auto move = entry(moves);
  const auto waits = entry(moves);
  const auto read = entry(reads);
  ASSERT_TRUE(queue.push(move));
  ASSERT_EQ(queue.next(), move);
  ASSERT_TRUE(queue.push(waits));
  ASSERT_TRUE(queue.push(read));
  EXPECT_EQ(queue.next(), read);
  EXPECT_EQ(queue.next(), nullptr);
}

TEST(ObjectQueue, RunsOneHandlerAtATimeForAServantThatIsNotThreadSafe) {
  ObjectQueue queue(LaneThreads::One);
  const auto move = entry(moves);
  const auto read = entry(reads);
  ASSERT_TRUE(queue.push(move));
  ASSERT_TRUE(queue.push(read));
  ASSERT_EQ(queue.next(), read) << "reading first, but not beside the motion";
  EXPECT_EQ(queue.next(), nullptr);
  finish(queue, *read);
  EXPECT_EQ(queue.next(), move);
}

TEST(ObjectQueue, LeavesThreeQuartersOfItsRoomToThoseWhoAreNoVisitors) {
  ObjectQueue queue(LaneThreads::Many);
  const auto of_visitor = [](std::uint64_t client, std::size_t bytes = 0) {
    auto made = std::make_shared<QueueEntry>(SessionId{client}, reads, bytes);
    made->of_visitor = true;
    return made;
  };
  for (std::uint64_t i = 0; i < ObjectQueue::most_of_visitors; ++i) {
    ASSERT_TRUE(queue.push(of_visitor(10 + i % 4)));
  }
  const auto full = queue.push(of_visitor(20));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error(), ObjectQueue::Full::Visitors);
  EXPECT_EQ(text_of(full.error(), 0),
            "64 calls of visitors are queued already; wait until one of them has ended");
  EXPECT_TRUE(queue.push(entry(reads)));
  EXPECT_TRUE(queue.push(entry(moves, bob)));
}

TEST(ObjectQueue, LeavesThreeQuartersOfItsBytesToThoseWhoAreNoVisitors) {
  ObjectQueue queue(LaneThreads::Many);
  constexpr std::size_t half = ObjectQueue::most_bytes_of_visitors / 2 + 1;
  const auto of_visitor = [&](SessionId client) {
    auto made = std::make_shared<QueueEntry>(client, reads, half);
    made->of_visitor = true;
    return made;
  };
  ASSERT_TRUE(queue.push(of_visitor(ada)));
  const auto full = queue.push(of_visitor(bob));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error(), ObjectQueue::Full::BytesOfVisitors);
  EXPECT_TRUE(queue.push(std::make_shared<QueueEntry>(bob, reads, half)));
}

TEST(ObjectQueue, PutsSafetyBeforeEverything) {
  OperationDescription halts = operation(access::Status::Sensor);
  halts.safety = true;
  ObjectQueue queue(LaneThreads::Many);
  const auto read = entry(reads);
  const auto halt = entry(halts);
  ASSERT_TRUE(queue.push(read));
  ASSERT_TRUE(queue.push(halt));
  EXPECT_EQ(queue.next(), halt);
}

TEST(ObjectQueue, RunsAParallelCommandBesideAnother) {
  OperationDescription blinks = operation(access::Status::Actor);
  blinks.parallel = true;
  ObjectQueue queue(LaneThreads::Many);
  const auto move = entry(moves);
  const auto blink = entry(blinks);
  const auto waits = entry(moves);
  for (const auto& one : {move, blink, waits}) ASSERT_TRUE(queue.push(one));
  EXPECT_EQ(queue.next(), move);
  EXPECT_EQ(queue.next(), blink);
  EXPECT_EQ(queue.next(), nullptr);
}

TEST(ObjectQueue, AParallelCommandDoesNotWaitForThoseBeforeIt) {
  OperationDescription blinks = operation(access::Status::Actor);
  blinks.parallel = true;
  ObjectQueue queue(LaneThreads::Many);
  const auto move = entry(moves), waits = entry(moves), blink = entry(blinks);
  for (const auto& one : {move, waits, blink}) ASSERT_TRUE(queue.push(one));
  EXPECT_EQ(queue.next(), move);
  EXPECT_EQ(queue.next(), blink);
  EXPECT_EQ(queue.next(), nullptr);
  finish(queue, *move);
  EXPECT_EQ(queue.next(), waits);
}

TEST(ObjectQueue, KeepsAnOrderedReadingBehindTheCommandsOfItsCallerOnly) {
  OperationDescription probes = operation(access::Status::Sensor);
  probes.ordered = true;
  ObjectQueue queue(LaneThreads::Many);
  const auto move = entry(moves, ada);
  const auto of_ada = entry(probes, ada);
  const auto of_bob = entry(probes, bob);
  ASSERT_TRUE(queue.push(move));
  ASSERT_TRUE(queue.push(of_ada));
  ASSERT_TRUE(queue.push(of_bob));
  EXPECT_EQ(queue.next(), of_bob);
  EXPECT_EQ(queue.next(), move);
  EXPECT_EQ(queue.next(), nullptr);
  finish(queue, *move);
  EXPECT_EQ(queue.next(), of_ada);
}

TEST(ObjectQueue, RefusesAClientThatFillsItAndStillTakesOthers) {
  ObjectQueue queue(LaneThreads::Many);
  for (std::size_t at = 0; at < ObjectQueue::most_of_client; ++at) {
    ASSERT_TRUE(queue.push(entry(moves, ada)));
  }
  const auto refused = queue.push(entry(moves, ada));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), ObjectQueue::Full::Client);
  EXPECT_TRUE(queue.push(entry(moves, bob)));
}

TEST(ObjectQueue, RefusesEverybodyWhenItIsFull) {
  ObjectQueue queue(LaneThreads::Many);
  for (std::size_t at = 0; at < ObjectQueue::most_of_object; ++at) {
    ASSERT_TRUE(queue.push(entry(moves, SessionId{1 + at / ObjectQueue::most_of_client})));
  }
  const auto refused = queue.push(entry(moves, SessionId{99}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), ObjectQueue::Full::Object);
}

TEST(ObjectQueue, HasRoomForOneThatReplacesTheCommandsThoughNotForOneThatFollowsThem) {
  OperationDescription replacing = moves;
  replacing.on_new = OnNew::Preempt;
  ObjectQueue queue(LaneThreads::Many);
  while (queue.push(entry(moves))) continue;
  EXPECT_TRUE(queue.push(entry(replacing)));
  EXPECT_FALSE(queue.push(entry(moves)));

  ObjectQueue reading(LaneThreads::Many);
  while (reading.push(entry(reads))) continue;
  EXPECT_FALSE(reading.push(entry(replacing))) << "what it does not replace stays";
}

TEST(ObjectQueue, TakesOutWhatHasNotStarted) {
  ObjectQueue queue(LaneThreads::Many);
  const auto first = entry(moves);
  const auto second = entry(moves);
  ASSERT_TRUE(queue.push(first));
  ASSERT_TRUE(queue.push(second));
  ASSERT_EQ(queue.next(), first);
  EXPECT_FALSE(queue.remove(*first));
  EXPECT_TRUE(queue.remove(*second));
  EXPECT_FALSE(queue.remove(*second));
  finish(queue, *first);
  EXPECT_EQ(queue.next(), nullptr);
}

std::shared_ptr<QueueEntry> large(std::size_t bytes, SessionId client = ada) {
  return std::make_shared<QueueEntry>(client, reads, bytes);
}

TEST(ObjectQueue, BoundsWhatTheCallsOfAClientTakeUntilTheyHaveEnded) {
  ObjectQueue queue(LaneThreads::Many);
  const auto first = large(ObjectQueue::most_bytes_of_client / 2);
  const auto second = large(ObjectQueue::most_bytes_of_client / 2);
  const auto third = large(ObjectQueue::small);
  ASSERT_TRUE(queue.push(first));
  ASSERT_TRUE(queue.push(second));
  EXPECT_EQ(queue.push(third).error(), ObjectQueue::Full::BytesOfClient);
  EXPECT_TRUE(queue.push(entry(reads))) << "small ones are bounded by their number";
  EXPECT_TRUE(queue.push(large(ObjectQueue::small, bob))) << "another client has its own share";
  ASSERT_EQ(queue.next(), first);
  EXPECT_EQ(queue.push(third).error(), ObjectQueue::Full::BytesOfClient) << "it has only started";
  finish(queue, *first);
  EXPECT_TRUE(queue.push(third));
}

TEST(ObjectQueue, BoundsWhatTheCallsOfAllClientsTake) {
  ObjectQueue queue(LaneThreads::Many);
  constexpr std::size_t share = ObjectQueue::most_bytes_of_client;
  for (std::uint64_t client = 1; client <= ObjectQueue::most_bytes_of_object / share; ++client) {
    ASSERT_TRUE(queue.push(large(share, SessionId{client})));
  }
  EXPECT_EQ(queue.push(large(ObjectQueue::small, SessionId{99})).error(),
            ObjectQueue::Full::BytesOfObject);
  EXPECT_EQ(queue.push(large(1, SessionId{99})).has_value(), true);
}

TEST(ObjectQueue, GivesBackWhatIsTakenOutBeforeItStarted) {
  ObjectQueue queue(LaneThreads::Many);
  const auto all = large(ObjectQueue::most_bytes_of_client);
  ASSERT_TRUE(queue.push(all));
  ASSERT_TRUE(queue.remove(*all));
  queue.ended(*all);
  EXPECT_TRUE(queue.push(large(ObjectQueue::most_bytes_of_client)));
}

TEST(ObjectQueue, TakesOneCallAloneWhateverItTakes) {
  ObjectQueue queue(LaneThreads::Many);
  EXPECT_TRUE(queue.push(large(ObjectQueue::most_bytes_of_object * 2)));
}

TEST(ObjectQueue, ReadingsOfOthersStartBesideThoseOfAClientThatMustWait) {
  ObjectQueue queue(LaneThreads::Many);
  const auto waits = entry(reads, ada);
  const auto starts = entry(reads, bob);
  ASSERT_TRUE(queue.push(waits));
  ASSERT_TRUE(queue.push(starts));
  const auto not_of_ada = [](const QueueEntry& which) { return which.client != ada; };
  EXPECT_EQ(queue.next(not_of_ada), starts);
  EXPECT_EQ(queue.next(not_of_ada), nullptr);
  EXPECT_EQ(queue.next(), waits);
}

TEST(ObjectQueue, ReadersTakeTurns) {
  constexpr SessionId cem{3};
  ObjectQueue queue(LaneThreads::One);
  std::vector<std::shared_ptr<QueueEntry>> of_ada;
  for (int reading = 0; reading < 4; ++reading) {
    of_ada.push_back(entry(reads, ada));
    ASSERT_TRUE(queue.push(of_ada.back()));
  }
  const auto starts = [&](const std::shared_ptr<QueueEntry>& expected) {
    const auto next = queue.next();
    EXPECT_EQ(next, expected);
    if (next) finish(queue, *next);
  };
  starts(of_ada[0]);
  const auto of_bob = entry(reads, bob);
  const auto of_cem = entry(reads, cem);
  ASSERT_TRUE(queue.push(of_bob));
  ASSERT_TRUE(queue.push(of_cem));
  starts(of_ada[1]);  // it was Ada's turn when Bob came
  starts(of_bob);
  const auto again = entry(reads, bob);
  ASSERT_TRUE(queue.push(again));
  starts(of_cem);
  starts(of_ada[2]);
  starts(again);
  EXPECT_TRUE(queue.remove(*of_ada[3]));
  starts(nullptr);
  EXPECT_TRUE(queue.idle());
}

TEST(ObjectQueue, AReaderThatMustWaitKeepsItsTurn) {
  ObjectQueue queue(LaneThreads::Many);
  const auto waits = entry(reads, ada);
  ASSERT_TRUE(queue.push(waits));
  const auto first = entry(reads, bob), second = entry(reads, bob);
  ASSERT_TRUE(queue.push(first));
  ASSERT_TRUE(queue.push(second));
  EXPECT_EQ(queue.next([](const QueueEntry& which) { return which.client != ada; }), first);
  EXPECT_EQ(queue.next(), waits);
  EXPECT_EQ(queue.next(), second);
}

TEST(ObjectQueue, ActorCommandsKeepTheirOrderBehindOneThatMustWait) {
  ObjectQueue queue(LaneThreads::Many);
  const auto waits = entry(moves, ada);
  const auto behind = entry(moves, bob);
  ASSERT_TRUE(queue.push(waits));
  ASSERT_TRUE(queue.push(behind));
  EXPECT_EQ(queue.next([](const QueueEntry& which) { return which.client != ada; }), nullptr);
  EXPECT_EQ(queue.next(), waits);
}

}  // namespace
}  // namespace gecos::session
