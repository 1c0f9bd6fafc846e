// What a caller asked for after a command that did not succeed, before it has seen that, is left
// out: over every medium, and whenever it arrives.
#include <algorithm>
#include <future>
#include <vector>

#include "../settles.hpp"
#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace {

using gecos::Detail;
using Steps = std::vector<gecos::Command<std::int32_t>>;

class LeftOut : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    probe_ = connect(lab_);
    lease_.emplace(*gecos::actor(probe_));
  }
  /// Expects that `step` ended as `detail` with a text that contains `words`.
  static void expect_ended(const gecos::Command<std::int32_t>& step, Detail detail,
                           const std::string& words) {
    const auto ended = step.get();
    ASSERT_FALSE(ended) << words;
    EXPECT_EQ(ended.error().detail, detail) << ended.error();
    EXPECT_NE(ended.error().text.find(words), std::string::npos) << ended.error();
  }
  static void expect_left_out(const gecos::Command<std::int32_t>& step) {
    expect_ended(step, Detail::Rejected,
                 "'step' of PROBE was not carried out, because the earlier command 'step' of the "
                 "same caller did not succeed: FAULT, ");
  }
  /// Waits until the reply to `step` is there, without a look of the program at it.
  static bool ends_unseen(const gecos::Command<std::int32_t>& step) {
    return settles(
        [&] { return gecos::project(step.core()->progress().detail) != gecos::State::Running; });
  }
  using Events = std::vector<std::string>;

  probe::Probe probe_;
  std::optional<gecos::Lease> lease_;
};
PROBE_OVER_MEDIA(LeftOut);

TEST_P(LeftOut, AreThoseAfterAFirstCommandThatIsRefused) {
  const Steps steps{probe_.step(-1), probe_.step(2), probe_.step(3)};
  expect_left_out(steps[2]);
  expect_left_out(steps[1]);
  expect_ended(steps[0], Detail::Fault, "");
  EXPECT_EQ(servant_.events(), (Events{"refuse -1"}));
}

TEST_P(LeftOut, AreThoseAfterOneInTheMiddleAndNotThoseBeforeIt) {
  const auto first = probe_.step(1);
  servant_.await_event("start 1");
  const Steps steps{first, probe_.step(-2), probe_.step(3), probe_.step(4)};
  servant_.await_event("refuse -2");
  servant_.open_gate();
  EXPECT_EQ(steps[0].get().value_or(0), 1);
  expect_left_out(steps[2]);
  expect_left_out(steps[3]);
  EXPECT_EQ(servant_.events(), (Events{"start 1", "refuse -2", "end 1"}));
}

TEST_P(LeftOut, IsNothingBeforeALastCommandThatIsRefused) {
  servant_.open_gate();
  const Steps steps{probe_.step(1), probe_.step(2), probe_.step(-3)};
  EXPECT_EQ(steps[0].get().value_or(0), 1);
  EXPECT_EQ(steps[1].get().value_or(0), 2);
  EXPECT_EQ(steps[2].wait(), gecos::State::CommandFailed);
  EXPECT_EQ(probe_.step(4).get().value_or(0), 4);
}

TEST_P(LeftOut, AreCommandsThatWereIssuedLongAfterTheFailureButBeforeTheProgramHasSeenIt) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  servant_.await_event("refuse -1");
  EXPECT_TRUE(probe_.read().get()) << "which reads the reply of the refused command, too";
  const auto later = probe_.step(2);
  servant_.publish(0);
  EXPECT_TRUE(probe_.read().get());
  const auto last = probe_.step(3);
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
  EXPECT_EQ(probe_.step(4).get().value_or(0), 4) << "the program has seen the failure";
  expect_left_out(later);
  expect_left_out(last);
  EXPECT_EQ(probe_.step(5).get().value_or(0), 5);
}

TEST_P(LeftOut, EndsOnlyOneChainForEachFailureThatIsSeen) {
  servant_.open_gate();
  const auto first = probe_.step(-1);
  const auto left_out = probe_.step(2);
  EXPECT_EQ(first.wait(), gecos::State::CommandFailed);
  const auto second = probe_.step(-3);
  expect_left_out(left_out);  // of the chain that the program has left
  const auto after_second = probe_.step(4);
  expect_left_out(after_second);
  EXPECT_EQ(second.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, AreThoseAfterACommandThatWaitsAndIsCanceled) {
  const Steps steps{probe_.step(1)};
  const auto queued = probe_.set(7);  // does not blend, and so holds up the steps after it
  const Steps waiting{probe_.step(2), probe_.step(3), probe_.step(4)};
  servant_.await_moves(1);
  waiting[1].cancel();
  expect_ended(waiting[1], Detail::Canceled, "canceled before it started");
  expect_ended(waiting[2], Detail::Canceled, "an earlier command of the same client was canceled");
  const auto anew = probe_.step(5);
  servant_.open_gate();
  EXPECT_EQ(steps[0].get().value_or(0), 1);
  EXPECT_EQ(waiting[0].get().value_or(0), 2);
  EXPECT_EQ(anew.get().value_or(0), 5) << "issued after the cancel";
  EXPECT_EQ(queued.get().value_or(0), 7);
}

TEST_P(LeftOut, AreThoseAfterACommandThatRunsAndIsCanceled) {
  const Steps steps{probe_.step(1), probe_.step(2)};
  const auto queued = probe_.set(7);
  const auto waiting = probe_.step(3);
  servant_.await_moves(2);
  steps[0].cancel();
  expect_ended(steps[0], Detail::Canceled, "");
  expect_ended(steps[1], Detail::Canceled, "");
  expect_ended(queued, Detail::Canceled, "an earlier command of the same client was canceled");
  expect_ended(waiting, Detail::Canceled, "an earlier command of the same client was canceled");
  servant_.open_gate();
  EXPECT_EQ(probe_.step(4).get().value_or(0), 4);
}

TEST_P(LeftOut, AreThoseThatWereIssuedAfterACancelIfACommandThatRanBeforeThenFails) {
  const auto runs = gecos::with(probe_, {.deadline = std::chrono::seconds(1)}).step(1);
  const auto queued = probe_.set(7);  // does not blend, and so holds up the steps after it
  const auto canceled = probe_.step(2);
  servant_.await_moves(1);
  canceled.cancel();
  const auto anew = probe_.step(3);
  expect_ended(runs, Detail::TimedOut, "");
  expect_ended(anew, Detail::Rejected, "did not succeed: TIMED_OUT, ");
  servant_.open_gate();
  EXPECT_EQ(probe_.step(4).get().value_or(0), 4);
  EXPECT_TRUE(queued.get());
}

TEST_P(LeftOut, AreThoseAfterAFailureOfWhichOnlyACommandThatEndedWellWasDetached) {
  servant_.open_gate();
  const auto done = probe_.step(1);
  EXPECT_EQ(done.wait(), gecos::State::Finished);
  const auto refused = probe_.step(-2);
  servant_.await_event("refuse -2");
  done.detach();
  done.cancel();
  expect_left_out(probe_.step(3));
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, AreThoseAfterACancelOfACommandThatWasLeftOut) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  const auto left_out = probe_.step(2);
  ASSERT_TRUE(ends_unseen(left_out));
  left_out.cancel();
  expect_left_out(probe_.step(3));
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, AreThoseAfterAFailureAlsoIfTheProgramHasSeenALaterOne) {
  const auto runs = gecos::with(probe_, {.deadline = std::chrono::milliseconds(500)}).step(1);
  const auto refused = probe_.step(-2);
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
  ASSERT_TRUE(ends_unseen(runs));
  servant_.open_gate();
  expect_ended(probe_.step(3), Detail::Rejected, "did not succeed: TIMED_OUT, ");
  EXPECT_EQ(probe_.step(4).get().value_or(0), 4) << "the text named the failure of 1";
  EXPECT_EQ(runs.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, AreThoseAfterAFailureAlsoIfAnotherCommandWasDetached) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  const auto detached = probe_.step(2);
  detached.detach();
  expect_left_out(probe_.step(3));
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, IsNothingAfterAStopOfTheOwnProgram) {
  const auto runs = probe_.step(1);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::stop(probe_).get());
  servant_.open_gate();
  EXPECT_EQ(probe_.step(2).get().value_or(0), 2) << "the program moves out of the way at once";
  expect_ended(runs, Detail::Stopped, "");
}

TEST_P(LeftOut, AreThoseAfterAFailureEvenIfTheStatusIsAcquiredOnceMore) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  servant_.await_event("refuse -1");
  const auto again = gecos::actor(probe_);
  ASSERT_TRUE(again);
  expect_left_out(probe_.step(2));
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, AreThoseAfterACommandForWhichTheQueueWasFull) {
  const auto runs = probe_.move(1);
  servant_.await_moves(1);
  Steps steps;
  while (steps.size() < 70) steps.push_back(probe_.step(static_cast<int>(steps.size())));
  ASSERT_TRUE(ends_unseen(steps.back()));
  servant_.open_gate();
  ASSERT_TRUE(runs.get());
  for (int at = 0; at < 64; ++at) EXPECT_EQ(steps[at].get().value_or(-1), at);
  const auto later = probe_.step(100);  // there is room again
  expect_ended(later, Detail::Rejected, "did not succeed: QUEUE_FULL, ");
  auto failed = std::ranges::find_if(
      steps, [](const auto& step) { return step.wait() == gecos::State::CommandFailed; });
  ASSERT_NE(failed, steps.end());
  expect_ended(*failed, Detail::QueueFull, "");
  while (++failed != steps.end()) {
    expect_ended(*failed, Detail::Rejected, "did not succeed: QUEUE_FULL, ");
  }
  EXPECT_EQ(probe_.step(101).get().value_or(0), 101) << "the program has seen it";
}

TEST_P(LeftOut, AreThoseAfterACommandThatWasNotSent) {
  std::promise<void> all_have_arrived;
  std::vector<gecos::IncomingCall> unanswered;
  servant_.on_read([&](gecos::IncomingCall call) {
    unanswered.push_back(std::move(call));
    if (unanswered.size() == 256) all_have_arrived.set_value();
  });
  servant_.open_gate();
  Steps reads;
  while (reads.size() < 256) reads.push_back(probe_.read());
  const auto unsent = probe_.step(1);
  all_have_arrived.get_future().wait();
  for (auto& call : unanswered) call.fail(gecos::Fault::rejected("enough").failure());
  for (const auto& read : reads) EXPECT_EQ(read.wait(), gecos::State::CommandFailed);
  const auto later = probe_.step(2);
  const std::string why = "was not sent, because an earlier command of the same caller ";
  expect_ended(later, Detail::Rejected, why + "was not sent: QUEUE_FULL, ");
  EXPECT_EQ(probe_.step(3).get().value_or(0), 3) << "the program has seen it";
  EXPECT_EQ(unsent.get().error().detail, Detail::QueueFull);
}

TEST_P(LeftOut, IsNothingAfterAFailureThatTheProgramDoesNotNeed) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  refused.detach();
  EXPECT_EQ(probe_.step(2).get().value_or(0), 2);
}

TEST_P(LeftOut, IsNothingUnderANewStatus) {
  servant_.open_gate();
  const auto refused = probe_.step(-1);
  ASSERT_TRUE(ends_unseen(refused));  // a status that drains is the same one when it is acquired
  lease_.reset();
  lease_.emplace(*gecos::actor(probe_));
  EXPECT_EQ(probe_.step(2).get().value_or(0), 2);
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

TEST_P(LeftOut, IsNothingOfAnotherClientOfTheStatus) {
  servant_.open_gate();
  lease_.reset();
  const auto other = connect(second_lab_);
  const auto one_lease = *gecos::actor(probe_, "two hands");
  const auto other_lease = *gecos::actor(other, "two hands");
  const auto refused = probe_.step(-1);
  servant_.await_event("refuse -1");
  EXPECT_EQ(other.step(2).get().value_or(0), 2);
  expect_left_out(probe_.step(3));
  EXPECT_EQ(other.step(4).get().value_or(0), 4);
  EXPECT_EQ(refused.wait(), gecos::State::CommandFailed);
}

using LeftOutHere = probe::Bench;

TEST_F(LeftOutHere, AreThoseThatRunBesideACommandWhoseDeadlinePasses) {
  serve("PROBE", servant_);
  const auto probe = connect(lab_);
  const auto lease = *gecos::actor(probe);
  const auto late = gecos::with(probe, {.deadline = std::chrono::seconds(2)}).step(1);
  const Steps steps{probe.step(2), probe.step(3)};
  servant_.await_moves(3);
  EXPECT_EQ(late.get().error().detail, Detail::TimedOut);
  for (const auto& step : steps) {
    const auto ended = step.get();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, Detail::Rejected);
    EXPECT_NE(ended.error().text.find("did not succeed: TIMED_OUT, "), std::string::npos);
  }
}

}  // namespace

namespace gecos::session {
namespace {

class LeftOutAtTheServer : public ServedObjects {
 protected:
  void step(std::uint64_t counter, std::int8_t flags = 0) {
    packet(wire::PacketKind::Call, counter, probe::step_code, Bytes(4), epoch_, flags);
  }
  /// Sends a step whose program knew `known` when it issued the step.
  void step_that_reports(std::uint64_t counter, const ChainReport& known) {
    Bytes body(known.encoded_size() + 4);
    wire::Encoder to(body);
    known.encode(to);
    packet(wire::PacketKind::Call, counter, probe::step_code, body, epoch_, reports);
  }
  /// Ends the kept call of the lowest counter as refused.
  void refuse_first() {
    auto call = std::move(servant_.kept.front());
    servant_.kept.erase(servant_.kept.begin());
    call.fail(Fault::rejected("out of reach").failure());
  }
  void SetUp() override {
    servant_.keep = true;
    acquire(1);
    epoch_ = granted();
  }
  Epoch epoch_{};
};

TEST_F(LeftOutAtTheServer, AreCallsThatArriveAfterTheFailureUntilOneBeginsAnew) {
  step(2);
  ASSERT_TRUE(settles([&] { return servant_.calls == 1; }));
  refuse_first();
  step(3);
  EXPECT_EQ(reply_to(3), Detail::Rejected);
  EXPECT_NE(failure().find("'step' of the same caller did not succeed: "
                           "REJECTED, out of reach"),
            std::string::npos)
      << failure();
  step(4);
  EXPECT_EQ(reply_to(4), Detail::Rejected);
  step_that_reports(5, {{{2, ChainReport::Known::Failure}}});
  EXPECT_EQ(reply_to(5), std::nullopt);
  ASSERT_TRUE(settles([&] { return servant_.calls == 2; }));
}

TEST_F(LeftOutAtTheServer,
       AreQueuedCallsAlsoThoseThatReportAnotherFailureAndNotThoseThatStandAlone) {
  step(2);
  ASSERT_TRUE(settles([&] { return servant_.calls == 1; }));
  step(3);
  step_that_reports(4, {{{1, ChainReport::Known::Failure}}});
  step(5, stands_alone);
  refuse_first();
  EXPECT_EQ(reply_to(3), Detail::Rejected);
  EXPECT_EQ(reply_to(4), Detail::Rejected) << "its program did not know how 2 ends";
  ASSERT_TRUE(settles([&] { return servant_.calls == 2; }));
  EXPECT_EQ(reply_to(5), std::nullopt);
}

TEST_F(LeftOutAtTheServer, AreCallsThatArriveAfterTheCancelOfOneThatRuns) {
  step(2);
  ASSERT_TRUE(settles([&] { return servant_.calls == 1; }));
  packet(wire::PacketKind::Cancel, 2);
  step(3);
  EXPECT_EQ(reply_to(3), Detail::Canceled) << "it was issued before the cancel, and came after it";
  step_that_reports(4, {{{2, ChainReport::Known::Canceled}}});
  EXPECT_EQ(reply_to(4), std::nullopt);
}

TEST_F(LeftOutAtTheServer, AreRefusedIfTheirReportDoesNotDecode) {
  packet(wire::PacketKind::Call, 2, probe::step_code, Bytes(4, std::byte{0x7f}), epoch_, reports);
  EXPECT_EQ(reply_to(2), Detail::BadParameter);
  step(3);
  EXPECT_EQ(reply_to(3), Detail::Rejected);
}

TEST_F(LeftOutAtTheServer, AreRefusedIfTheirFlagsAreUnknown) {
  std::uint64_t counter = 2;
  for (const std::int8_t flags : {std::int8_t{4}, std::int8_t{127}, std::int8_t{-1}}) {
    step(counter, flags);
    EXPECT_EQ(reply_to(counter), Detail::BadParameter);
    EXPECT_EQ(failure(), "the call has the flags " + std::to_string(flags) +
                             "; this server knows only the flags 0 to 3; update the server");
    ++counter;
  }
  EXPECT_EQ(servant_.calls, 0);
}

TEST_F(LeftOutAtTheServer, AreNoCallsOfAnOperationThatDoesNotBlend) {
  step(2);
  ASSERT_TRUE(settles([&] { return servant_.calls == 1; }));
  call(3, probe::set_code, {}, epoch_);
  refuse_first();
  ASSERT_TRUE(settles([&] { return servant_.calls == 2; }));
  EXPECT_EQ(reply_to(3), std::nullopt);
}

}  // namespace
}  // namespace gecos::session
