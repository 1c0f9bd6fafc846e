// What is said of a command that has not started: early, unknown, barred. (The rest: outcome_test.)
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

class OutcomesOf : public OverALossyLine {
 protected:
  /// Asked by a session of its own, as somebody who lost his would.
  Outcome ask(SessionId session, std::uint64_t counter) {
    const auto asked = std::exchange(session_, nullptr);
    TestConnection* const asked_connection = connection_;
    connect();
    Bytes body(3 * 8);
    wire::Encoder to(body);
    to.put(number(process_incarnation()));
    to.put(number(session));
    to.put(counter);
    call(1, GecosObjectInterface::outcome.code, body);
    const auto packet = wire::decode_packet(connection_->sent.back());
    wire::Decoder from(packet->body);
    OutcomeRecord record;
    EXPECT_TRUE(wire::get_block(from, record, "outcome"));
    session_ = asked;
    connection_ = asked_connection;
    return {detail_from(record.detail).value_or(Detail::Fault), record.text};
  }
};

TEST_F(OutcomesOf, AnEarlyCommandSayThatItWaits) {
  acquire(1);
  call(3, probe::set_code, {}, granted());
  EXPECT_EQ(ask(session_->id(), 3).detail, Detail::Queued);
  EXPECT_EQ(servant_.calls, 0) << "asking starts nothing";
}

TEST_F(OutcomesOf, ACommandThatHasNotComePromiseThatItDoesNotStart) {
  acquire(1);
  const Epoch epoch = granted();
  EXPECT_EQ(ask(session_->id(), 2).detail, Detail::NotStarted);
  EXPECT_EQ(reply_to(2), Detail::NotStarted) << "its caller is told too";
  call(2, probe::set_code, {}, epoch);
  EXPECT_EQ(servant_.calls, 0) << "it was late";
  EXPECT_EQ(ask(session_->id(), 2).state(), State::CommandFailed)
      << "it came to an end; of commands that never were, none is kept";
}

TEST_F(OutcomesOf, ACommandThatIsBarredLetTheNextOnesStart) {
  acquire(1);
  const Epoch epoch = granted();
  call(3, probe::set_code, {}, epoch);
  ASSERT_EQ(servant_.calls, 0) << "it waits for 2";
  EXPECT_EQ(ask(session_->id(), 2).detail, Detail::NotStarted);
  object_->run_ready(Starter::Poller);
  EXPECT_EQ(servant_.calls, 1);
  EXPECT_EQ(reply_to(3), Detail::Done);
}

TEST_F(OutcomesOf, ASessionThatNobodyKnowsAreUnknown) {
  const auto outcome = ask(SessionId{4711}, 1);
  EXPECT_EQ(outcome.detail, Detail::OutcomeUnknown);
  EXPECT_FALSE(outcome.text.empty());
}

TEST_F(OutcomesOf, ASessionThatEndedTellWhatHadComeFromWhatHadNot) {
  acquire(1);
  const Epoch epoch = granted();
  call(2, probe::set_code, {}, epoch);
  call(4, probe::set_code, {}, epoch);
  object_->depart(session_, ObjectHost::Departure::Lost);
  EXPECT_EQ(ask(session_->id(), 2).detail, Detail::Done);
  EXPECT_EQ(ask(session_->id(), 3).detail, Detail::NotStarted);
  EXPECT_EQ(ask(session_->id(), 4).detail, Detail::Rejected) << "it waited for 3, in vain";
}

}  // namespace
}  // namespace gecos::session
