// What a served object does with packets that no client of ours would send, or not so late.
#include <future>

#include "../settles.hpp"
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

TEST_F(ServedObjects, TakesNothingMoreOfASessionThatHasEnded) {
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
  object_->depart(session_, ObjectHost::Departure::Lost);
  EXPECT_EQ(servant_.sessions_ended, 1);
  call(2, probe::read_code);
  EXPECT_EQ(reply_to(2), std::nullopt);
  acquire(3);
  EXPECT_EQ(reply_to(3), std::nullopt);
}

TEST_F(ServedObjects, KeepNoSessionThatNobodyElseHas) {
  acquire(1);
  ASSERT_EQ(reply_to(1), Detail::Done);
  const std::weak_ptr<ServerSession> holder = connect();
  EXPECT_TRUE(holder.expired());
}

TEST_F(ServedObjects, AdmitNoSampleOfALostSessionWhenAnotherOneGetsItsStatus) {
  acquire(1);
  session_->standing->set(access::Status::Actor, granted());  // it feeds an inward stream
  const auto lost = connect();
  acquire(1, 60);
  EXPECT_EQ(reply_to(1), std::nullopt) << "it waits";
  bool fed = true;
  connection_->on_send = [&] { fed = lost->standing->epoch(access::Status::Actor).has_value(); };
  object_->depart(lost, ObjectHost::Departure::Lost);
  connection_->on_send = {};
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_FALSE(fed);
}

TEST_F(ServedObjects, TellAHandlerWhenItsStartWasMarked) {
  const TimePoint before = system_clock().since_boot() - std::chrono::milliseconds(50);
  call(1, probe::read_code);
  ASSERT_TRUE(servant_.marked_at);
  EXPECT_GE(*servant_.marked_at, before);
  EXPECT_LE(*servant_.marked_at, system_clock().since_boot());
}

TEST_F(ServedObjects, MarkWhatAServantQueuesWhenItBeginsIt) {
  servant_.queues = servant_.keep = true;
  call(1, probe::read_code);
  EXPECT_FALSE(servant_.marked_at);
  const TimePoint later = system_clock().since_boot();
  ASSERT_TRUE(servant_.kept.at(0).begin());
  EXPECT_GE(servant_.kept[0].marked_at(), later);
}

TEST_F(ServedObjects, BeginNothingThatWaitedForItsThreadDuringAPauseUnlessItsCallerWasHeardSince) {
  servant_.queues = servant_.keep = true;
  call(1, probe::read_code);
  call(2, probe::read_code);
  object_->await_sign_of_life(*session_);
  EXPECT_FALSE(servant_.kept.at(0).begin());
  EXPECT_EQ(reply_to(1), Detail::NotStarted);
  ASSERT_FALSE(object_->check_liveness(session_));
  EXPECT_TRUE(servant_.kept.at(1).begin());
}

TEST_F(ServedObjects, BeginNothingAfterAPauseBeforeWhatCameAheadOfTheHeartbeatIsRead) {
  servant_.queues = servant_.keep = true;
  call(1, probe::read_code);
  call(2, probe::read_code);
  object_->await_sign_of_life(*session_);
  connection_->unread = true;
  ASSERT_FALSE(object_->check_liveness(session_));
  EXPECT_FALSE(servant_.kept.at(0).begin())
      << "the packet may be a Goodbye that withdraws the call";
  EXPECT_EQ(reply_to(1), Detail::NotStarted);
  connection_->unread = false;
  ASSERT_FALSE(object_->check_liveness(session_));
  EXPECT_TRUE(servant_.kept.at(1).begin());
}

TEST_F(ServedObjects, RefuseWhatLayUnreadForTooLongAlsoIfThePauseIsNotJudgedYet) {
  session_->intake.accept_within(std::chrono::milliseconds(750));
  // The maintenance thread, which would judge the pause, waits meanwhile.
  std::promise<void> waits, judges;
  runtime_->maintenance().post([&waits, may_go_on = judges.get_future().share()] {
    waits.set_value();
    may_go_on.wait();
  });
  waits.get_future().wait();
  PauseWatch& pauses = runtime_->maintenance().pauses();
  connection_->unread_for = std::chrono::seconds(1);
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done) << "without a pause, it waited for a handler";
  pauses.judged(clock_.since_boot());
  clock_.suspend(std::chrono::seconds(2));
  call(2, probe::read_code);
  EXPECT_EQ(reply_to(2), Detail::NotStarted);
  connection_->unread_for = std::chrono::milliseconds(700);
  call(3, probe::read_code);
  EXPECT_EQ(reply_to(3), std::nullopt) << "it waits until the pause is judged";
  pauses.judged(TimePoint::max());
  object_->run_ready(Starter::Poller);
  EXPECT_EQ(reply_to(3), Detail::Done);
  judges.set_value();
}

TEST_F(ServedObjects, RefuseWhatWasSentBeforeAPauseEndedAlsoIfAHeartbeatIsReadFirst) {
  session_->intake.accept_within(std::chrono::milliseconds(750));
  // The maintenance thread, which would find the pause, waits meanwhile.
  std::promise<void> waits, goes_on;
  runtime_->maintenance().post([&waits, may_go_on = goes_on.get_future().share()] {
    waits.set_value();
    may_go_on.wait();
  });
  waits.get_future().wait();
  PauseWatch& pauses = runtime_->maintenance().pauses();
  pauses.judged(clock_.since_boot());
  clock_.suspend(std::chrono::seconds(2));
  ASSERT_TRUE(pauses.tick(clock_.since_boot()));
  object_->await_sign_of_life(*session_);
  pauses.judged(TimePoint::max());
  ASSERT_FALSE(object_->check_liveness(session_)) << "the heartbeat is there";
  connection_->unread_for = std::chrono::seconds(1);
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::NotStarted);
  call(2, GecosObjectInterface::stop.code);
  EXPECT_EQ(reply_to(2), Detail::Done) << "a stop takes effect however old it is";
  clock_.suspend(std::chrono::seconds(2));
  call(3, probe::read_code);
  EXPECT_EQ(reply_to(3), Detail::Done) << "it was sent after the pause";
  goes_on.set_value();
}

TEST_F(ServedObjects, LetNoSampleOfAClientActAfterAPauseBeforeTheClientIsHeard) {
  EXPECT_FALSE(session_->standing->unheard());
  object_->await_sign_of_life(*session_);
  EXPECT_TRUE(session_->standing->unheard());
  connection_->unread = true;
  ASSERT_FALSE(object_->check_liveness(session_));
  EXPECT_TRUE(session_->standing->unheard());
  connection_->unread = false;
  ASSERT_FALSE(object_->check_liveness(session_));
  EXPECT_FALSE(session_->standing->unheard());
}

TEST_F(ServedObjects, BeginNothingThatWaitsForItsThreadAndWasWithdrawn) {
  servant_.queues = servant_.keep = true;
  call(1, probe::read_code);
  packet(wire::PacketKind::Goodbye, 0, {}, {}, {}, withdraws);
  EXPECT_FALSE(servant_.kept.at(0).begin());
  EXPECT_EQ(reply_to(1), Detail::NotStarted);
}

TEST_F(ServedObjects, TakeAGoodbyeThatWasSentDuringAPauseForOneThatWithdraws) {
  servant_.queues = servant_.keep = true;
  call(1, probe::read_code);
  object_->await_sign_of_life(*session_);
  packet(wire::PacketKind::Goodbye, 0);
  EXPECT_FALSE(servant_.kept.at(0).begin());
  EXPECT_EQ(reply_to(1), Detail::NotStarted);
  object_->depart(session_, ObjectHost::Departure::Lost);
}

TEST_F(ServedObjects, KeepABoundedNumberOfRequestsForStatusWaitingForAHandler) {
  acquire(1);
  const Epoch epoch = granted();
  servant_.keep = true;
  call(2, probe::set_code, {}, epoch);
  ASSERT_EQ(servant_.kept.size(), 1u);
  release(3, epoch, true);
  for (std::uint64_t counter = 4; counter < 4 + 64; ++counter) acquire(counter);
  EXPECT_EQ(reply_to(4), std::nullopt) << "its predecessor's handler still runs";
  EXPECT_EQ(reply_to(4 + 63), std::nullopt);
  acquire(100);
  EXPECT_EQ(reply_to(100), Detail::QueueFull);
  servant_.kept[0].finish({});
  object_->run_ready(Starter::Poller);
  EXPECT_EQ(reply_to(4), Detail::Done);
}

TEST_F(ServedObjects, SayThatASessionEndedOnceNoCallOfItIsUnderWay) {
  servant_.keep = true;
  call(1, probe::read_code);
  object_->depart(session_, ObjectHost::Departure::Lost);
  EXPECT_EQ(servant_.sessions_ended, 0) << "its handler still uses what belongs to the session";
}

TEST_F(ServedObjects, LetsNobodyEndTheSessionOfAnother) {
  acquire(1);
  const Epoch epoch = granted();
  wire::PacketHeader foreign;
  foreign.kind = wire::PacketKind::Goodbye;
  foreign.session = SessionId{4711};
  take(foreign);
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(2), Detail::Done);
  EXPECT_FALSE(session_->left);
}

TEST_F(ServedObjects, StopsWhatAnswersLaterToo) {
  acquire(1);
  const Epoch epoch = granted();
  servant_.keep = true;
  call(2, probe::set_code, {}, epoch);
  ASSERT_EQ(servant_.kept.size(), 1u);
  call(3, GecosObjectInterface::stop.code);
  EXPECT_EQ(reply_to(2), Detail::Stopped);
  EXPECT_TRUE(servant_.kept[0].interrupted());
}

TEST_F(ServedObjects, TakeAStatusBackUnderTheEpochItWasGivenHoweverOftenItsHolderStoppedSince) {
  const auto stop = GecosObjectInterface::stop.code;
  acquire(1);
  const Epoch given = granted();
  for (std::uint64_t counter = 2; counter < 5; ++counter) call(counter, stop);
  acquire(5);
  const Epoch later = granted();
  ASSERT_NE(later, given);
  release(6, given);
  call(7, probe::set_code, {}, later);
  EXPECT_EQ(reply_to(7), Detail::Done) << "it was acquired twice";
  release(8, later);
  call(9, probe::set_code, {}, later);
  EXPECT_EQ(reply_to(9), Detail::LeaseLost);

  acquire(10);
  const Epoch new_epoch = granted();
  release(11, given);
  call(12, probe::set_code, {}, new_epoch);
  EXPECT_EQ(reply_to(12), Detail::Done) << "what ended before is not given back again";
}

TEST_F(ServedObjects, AreForgottenThoughTheyEndedBeforeAThreadCameToACallThatHadStarted) {
  for (int time = 0; time < 200; ++time) {
    acquire(1);
    servant_.keep = true;
    call(2, probe::move_code, {}, granted());
    object_->close();
    object_->join();
    servant_.kept.clear();
    EXPECT_EQ(reply_to(2), Detail::Stopped);
    object_->depart(session_, ObjectHost::Departure::Lost);
    session_.reset();
    const std::weak_ptr<ObjectHost> before = object_;
    object_ = make_object();
    ASSERT_TRUE(before.expired()) << "with its sessions and their descriptors";
    connect();
  }
}

TEST_F(ServedObjects, PartsFromAClientThatAsksAndNeverListens) {
  ASSERT_FALSE(object_->check_liveness(session_));
  connection_->full = true;
  bool parted = false;
  for (std::uint64_t counter = 1; counter < 100'000 && !parted; ++counter) {
    call(counter, GecosObjectInterface::ping.code);
    parted = session_->sender().overrun();
  }
  EXPECT_TRUE(parted);
  EXPECT_TRUE(object_->check_liveness(session_)) << "though it gives signs of life";
}

TEST_F(ServedObjects, GivesUpLargeResultsOfAClientThatTakesNone) {
  connection_->carry(32 * 1024 * 1024);
  connection_->full = true;
  servant_.result.resize(30 * 1024 * 1024);
  for (std::uint64_t counter = 1; counter <= 6; ++counter) call(counter, probe::read_code);
  EXPECT_FALSE(session_->sender().overrun());
  connection_->full = false;
  session_->sender().flush();
  for (std::uint64_t counter = 1; counter <= 4; ++counter)
    EXPECT_EQ(reply_to(counter), Detail::Done);
  EXPECT_EQ(reply_to(5), Detail::Fault);
  EXPECT_EQ(reply_to(6), Detail::Fault);
  call(7, probe::read_code);
  EXPECT_EQ(reply_to(7), Detail::Done) << "it has taken them";
}

TEST_F(ServedObjects, AnswerAClientWhileResultsWaitForAnotherOneThatTakesNone) {
  connection_->carry(32 * 1024 * 1024);
  connection_->full = true;
  TestConnection& slow = *connection_;
  const std::size_t before = slow.sent.size();
  servant_.result.resize(2'000'000);
  for (std::uint64_t counter = 1; counter <= 60; ++counter) call(counter, probe::read_code);
  servant_.result.clear();
  const auto slow_session = connect();
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
  EXPECT_EQ(slow.sent.size(), before) << "the slow client has taken nothing yet";
  slow.full = false;
  slow_session->sender().flush();
  EXPECT_EQ(slow.sent.size(), before + 60);
}

TEST_F(ServedObjects, PacketsThatCountNoCallAreIgnored) {
  connection_->sent.clear();
  for (const auto kind :
       {wire::PacketKind::Query, wire::PacketKind::Cancel, wire::PacketKind::Call}) {
    packet(kind, 0, probe::read_code);
  }
  EXPECT_TRUE(connection_->sent.empty());
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(ServedObjects, AnswersThatTheOutcomeOfNoCallIsNotKnown) {
  Bytes body(3 * 8);
  wire::Encoder to(body);
  to.put(number(process_incarnation()));
  to.put(number(session_->id()));
  to.put(std::uint64_t{0});
  call(1, GecosObjectInterface::outcome.code, body);
  ASSERT_EQ(reply_to(1), Detail::Done);
  OutcomeRecord record;
  const auto packet = wire::decode_packet(connection_->sent.back());
  wire::Decoder from(packet->body);
  ASSERT_TRUE(wire::get_block(from, record, "outcome"));
  EXPECT_EQ(detail_from(record.detail), Detail::OutcomeUnknown);
}

TEST_F(ServedObjects, WhatNobodyLooksAtStartsWithTheNextTick) {
  Bytes packet;
  write_packet(packet, header_of(wire::PacketKind::Call, 1, probe::read_code), {});
  object_->take(session_, packet);  // and its client is gone, and the poller sleeps
  EXPECT_EQ(servant_.calls, 0);
  object_->on_tick(system_clock().now());
  EXPECT_TRUE(settles([this] { return servant_.calls == 1; }));
}

TEST_F(ServedObjects, LetWhatFinishesOnLossGoOnWhenItsCallerHasBeenSilentForTheTimeToLive) {
  acquire(1);
  const Epoch epoch = granted();
  servant_.keep = true;
  call(2, probe::finish_code, {}, epoch);
  ASSERT_TRUE(settles([this] { return servant_.calls == 1; }));
  call(3, probe::finish_code, {}, epoch);
  TimePoint now = clock_.now();
  for (int look = 0; look < 3; ++look) object_->on_tick(now += std::chrono::milliseconds(100));
  EXPECT_EQ(reply_to(3), std::nullopt) << "300 ms are no loss yet";
  for (int look = 0; look < 3; ++look) object_->on_tick(now += std::chrono::milliseconds(100));
  EXPECT_EQ(reply_to(3), Detail::LeaseLost) << "it had not begun";
  EXPECT_EQ(reply_to(2), std::nullopt);
  EXPECT_FALSE(servant_.kept.at(0).interrupted());
  servant_.kept.at(0).finish({});
  EXPECT_EQ(reply_to(2), Detail::Done);
}

/// So long is the silence after which the broker lists an object as silent: its server is a client
/// of the broker.
TEST_F(ServedObjects, LoseAClientThatHasBeenSilentForOneAndAHalfSeconds) {
  using std::chrono::milliseconds;
  clock_.stop();
  ASSERT_FALSE(object_->check_liveness(session_));
  connection_->silent = true;
  const auto lost_after = [this](Duration more) {
    clock_.pass(more);
    return object_->check_liveness(session_);
  };
  for (int look = 0; look < 14; ++look) ASSERT_FALSE(lost_after(milliseconds(100)));
  EXPECT_FALSE(lost_after(milliseconds(99)));
  EXPECT_TRUE(lost_after(milliseconds(1)));
}

TEST_F(ServedObjects, ADeadlinePassesWhileTheMachineIsSuspended) {
  auto header = header_of(wire::PacketKind::Call, 1, probe::read_code);
  header.deadline = std::chrono::hours(1);
  Bytes packet;
  write_packet(packet, header, {});
  object_->take(session_, packet);
  clock_.suspend(std::chrono::hours(2));
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), Detail::Expired);
  EXPECT_EQ(servant_.calls, 0);
}

TEST_F(ServedObjects, ACallThatDidNotStartInTimeIsNotCarriedOut) {
  Bytes packet;
  write_packet(packet, header_of(wire::PacketKind::Call, 1, probe::prompt_code), {});
  object_->take(session_, packet);
  clock_.suspend(std::chrono::hours(2));
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), Detail::Expired);
  EXPECT_EQ(servant_.calls, 0);
}

TEST_F(ServedObjects, ACallThatStartedInTimeMayTakeLong) {
  servant_.keep = true;
  call(1, probe::prompt_code);
  ASSERT_EQ(servant_.kept.size(), 1U);
  clock_.suspend(std::chrono::hours(2));
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), std::nullopt);
  servant_.kept[0].finish({});
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(ServedObjects, ACallWhoseThreadComesTooLateIsNotBegun) {
  servant_.queues = servant_.keep = true;
  call(1, probe::prompt_code);
  clock_.suspend(std::chrono::hours(2));
  EXPECT_FALSE(servant_.kept.at(0).begin());
  EXPECT_EQ(reply_to(1), Detail::Expired);
}

TEST_F(ServedObjects, ADeadlineInCenturiesIsNone) {
  auto header = header_of(wire::PacketKind::Call, 1, probe::read_code);
  header.deadline = Duration::max();
  take(header);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(OverALossyLine, StartNothingOfAClientThatIsSilentBeforeItIsHeardAgain) {
  ASSERT_FALSE(object_->check_liveness(session_));
  connection_->silent = true;
  TimePoint now = system_clock().now();
  for (int look = 0; look < 4; ++look) object_->on_tick(now += std::chrono::milliseconds(200));
  ASSERT_FALSE(object_->check_liveness(session_));
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), std::nullopt) << "its client may have given it up";
  connection_->silent = false;
  ASSERT_FALSE(object_->check_liveness(session_));
  object_->run_ready(Starter::Poller);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(OverALossyLine, CallsOfAClientThatSaidGoodbyeAreNotHeldUpWhenItsSilenceIsJudgedOnceMore) {
  ASSERT_FALSE(object_->check_liveness(session_));
  connection_->silent = true;
  TimePoint now = system_clock().now();
  for (int look = 0; look < 4; ++look) object_->on_tick(now += std::chrono::milliseconds(200));
  ASSERT_FALSE(object_->check_liveness(session_));
  call(1, probe::read_code);
  ASSERT_EQ(servant_.calls, 0) << "the client is silent: the call waits";
  object_->depart(session_, ObjectHost::Departure::InOrder);
  object_->check_liveness(session_);  // by maintenance, which had listed the session before
  object_->run_ready(Starter::Poller);
  EXPECT_EQ(servant_.calls, 1) << "an ordered call that waits holds up the commands of all clients";
}

TEST_F(OverALossyLine, PacketsThatCountNoCallAreIgnored) {
  connection_->sent.clear();
  for (const auto kind :
       {wire::PacketKind::Query, wire::PacketKind::Cancel, wire::PacketKind::Call}) {
    packet(kind, 0, probe::read_code);
  }
  EXPECT_TRUE(connection_->sent.empty());
  call(1, probe::read_code);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(OverALossyLine, ACallWhoseAnswerWasCrowdedOutStillComesToAnEnd) {
  constexpr std::uint64_t kept = 512;
  for (std::uint64_t counter = 1; counter <= kept + 1; ++counter) call(counter, probe::read_code);
  connection_->sent.clear();  // the first answers were lost
  packet(wire::PacketKind::Query, 1);
  EXPECT_EQ(reply_to(1), Detail::OutcomeUnknown);
  packet(wire::PacketKind::Query, kept + 1);
  EXPECT_EQ(reply_to(kept + 1), Detail::Done);
}

TEST_F(OverALossyLine, AnAnswerThatHasNotGoneYetIsNotPutBehindItselfWhenItIsAskedFor) {
  connection_->full = true;
  call(1, probe::read_code);
  for (int times = 0; times < 3; ++times) packet(wire::PacketKind::Query, 1);
  connection_->full = false;
  connection_->sent.clear();
  session_->sender().flush();
  EXPECT_EQ(connection_->sent.size(), 1u);
}

TEST_F(OverALossyLine, ALateRepetitionOfWhatWasAcknowledgedIsIgnored) {
  call(1, probe::read_code);
  acknowledged_ = 1;
  call(2, probe::read_code);
  connection_->sent.clear();
  call(1, probe::read_code);
  EXPECT_TRUE(connection_->sent.empty());
}

TEST_F(OverALossyLine, AReleaseThatOvertakesACommandWaitsForIt) {
  acquire(1);
  const Epoch epoch = granted();
  release(3, epoch);
  EXPECT_EQ(reply_to(3), std::nullopt);
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(2), Detail::Done) << "what was issued before a release still runs";
  release(3, epoch);
  EXPECT_EQ(reply_to(3), Detail::Done);
}

TEST_F(OverALossyLine, ACommandThatOvertakesAnotherWaitsForIt) {
  acquire(1);
  const Epoch epoch = granted();
  connection_->sent.clear();
  call(4, probe::set_code, {}, epoch);
  call(3, probe::set_code, {}, epoch);
  call(3, probe::set_code, {}, epoch);
  packet(wire::PacketKind::Query, 3);
  EXPECT_TRUE(connection_->sent.empty()) << "as far as its caller knows it has not arrived";
  call(2, probe::set_code, {}, epoch);
  std::vector<std::uint64_t> answered;
  for (const Bytes& sent : connection_->sent) {
    const auto packet = wire::decode_packet(sent);
    if (packet->header.kind == wire::PacketKind::Reply) answered.push_back(packet->header.counter);
  }
  EXPECT_EQ(answered, (std::vector<std::uint64_t>{2, 3, 4}));
}

TEST_F(OverALossyLine, ACommandWaitsNoMoreForOneThatItsClientHasGivenUp) {
  acquire(1);
  const Epoch epoch = granted();
  call(4, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(4), std::nullopt);
  acknowledged_ = 3;  // 2 and 3 were readings, say, that are asked for elsewhere by now
  call(5, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(4), Detail::Done);
  EXPECT_EQ(reply_to(5), Detail::Done);
  const int before = servant_.calls;
  call(2, probe::read_code);
  EXPECT_EQ(servant_.calls, before) << "given up, it does not start late";
}

TEST_F(OverALossyLine, WhatIsTooFarAheadHasNotArrivedAndIsNotAnswered) {
  constexpr std::uint64_t far = 2 + 1024;
  call(far, probe::read_code);
  EXPECT_EQ(reply_to(far), std::nullopt) << "an answered one must never start, and this one may";
  for (std::uint64_t counter = 1; counter < 3; ++counter) call(counter, probe::read_code);
  call(far, probe::read_code);
  EXPECT_EQ(reply_to(far), Detail::Done);
  EXPECT_EQ(servant_.calls, 3);
}

TEST_F(OverALossyLine, WhatWasOnItsWayWhenTheDeviceWasStoppedIsStopped) {
  acquire(1);
  const Epoch epoch = granted();
  call(3, probe::set_code, {}, epoch);  // before the one that was issued before it
  const auto mover = connect();
  TestConnection& line = static_cast<TestConnection&>(mover->connection());
  call(1, GecosObjectInterface::stop.code);
  ASSERT_EQ(reply_to(1), Detail::Done);
  session_ = mover, connection_ = &line;
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(2), Detail::Stopped);
  EXPECT_EQ(reply_to(3), Detail::Stopped);
  EXPECT_EQ(servant_.calls, 0);
}

TEST_F(OverALossyLine, AReadingWaitsForNothing) {
  call(2, probe::read_code);
  EXPECT_EQ(reply_to(2), Detail::Done);
}

TEST_F(OverALossyLine, ACommandThatCameTooEarlyCanBeCanceled) {
  acquire(1);
  const Epoch epoch = granted();
  call(3, probe::set_code, {}, epoch);
  packet(wire::PacketKind::Cancel, 3);
  EXPECT_EQ(reply_to(3), Detail::Canceled);
  servant_.keep = true;
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(servant_.kept.size(), 1u) << "the canceled one never starts";
}

TEST_F(OverALossyLine, ACommandThatCameTooEarlyGoesWithItsSession) {
  acquire(1);
  call(3, probe::set_code, {}, granted());
  object_->depart(session_, ObjectHost::Departure::Lost);
  EXPECT_EQ(reply_to(3), Detail::Rejected) << "should anybody still hear it";
  EXPECT_EQ(session_->intake.aside(), 0U);
  EXPECT_EQ(servant_.sessions_ended, 1);
}

}  // namespace
}  // namespace gecos::session
