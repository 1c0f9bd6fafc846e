// What became of a command, asked by somebody who was not told.
#include "await_detail.hpp"
#include "over_media.hpp"

namespace {

using gecos::CommandId;
using gecos::Detail;
using gecos::State;

class Outcomes : public probe::OverMedia {
 protected:
  /// Asked through a session of another program.
  gecos::Outcome ask(const CommandId& id) {
    const auto answer = gecos::outcome(connect(second_lab_), id).get();
    EXPECT_TRUE(answer) << answer.error();
    return answer.value_or(gecos::Outcome{});
  }
};
PROBE_OVER_MEDIA(Outcomes);

/// Elsewhere nothing overtakes, and what is on its way arrives.
using OutcomesOverLossyMedia = Outcomes;
INSTANTIATE_TEST_SUITE_P(Over, OutcomesOverLossyMedia, ::testing::Values(gecos::media::Kind::Lcm),
                         gecos::media::name_of);

TEST_P(Outcomes, AreToldToOthersWhoKnowTheCommand) {
  servant_.open_gate();
  const auto robot = connect(lab_);
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = robot.move(1);
  ASSERT_EQ(move.wait(), State::Finished);
  EXPECT_EQ(ask(move.id()).detail, Detail::Done);
}

TEST_P(Outcomes, SayWhyACommandFailed) {
  const auto robot = connect(lab_);
  const auto denied = robot.set(1);
  ASSERT_EQ(denied.get().error().detail, Detail::Denied);
  EXPECT_EQ(ask(denied.id()).detail, Detail::Denied);
  EXPECT_EQ(ask(denied.id()).text, denied.get().error().text);
}

TEST_P(Outcomes, SayWhereACommandStands) {
  const auto robot = connect(lab_);
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = robot.move(1);
  const auto set = robot.set(2);
  servant_.await_moves(1);
  probe::await_detail(set, Detail::Queued);
  EXPECT_EQ(ask(move.id()).detail, Detail::Executing);
  EXPECT_EQ(ask(set.id()).detail, Detail::Queued);
  servant_.open_gate();
  ASSERT_EQ(set.wait(), State::Finished);
  EXPECT_EQ(ask(move.id()).detail, Detail::Done);
}

TEST_P(Outcomes, OutliveTheSession) {
  servant_.open_gate();
  CommandId done;
  CommandId never;
  {
    gecos::Lab lab(probe::patient());
    const auto robot = connect(lab);
    const auto lease = gecos::actor(robot);
    ASSERT_TRUE(lease) << lease.error();
    const auto move = robot.move(1);
    ASSERT_EQ(move.wait(), State::Finished);
    done = move.id();
    never = {done.incarnation, done.session, done.counter + 100};
  }
  EXPECT_EQ(ask(done).detail, Detail::Done);
  // Its goodbye may still be under way.
  auto outcome = ask(never);
  while (outcome.detail == Detail::Sent) outcome = ask(never);
  EXPECT_EQ(outcome.detail, Detail::NotStarted);
  EXPECT_EQ(outcome.state(), State::ConnectionFailed) << "sending it again is safe";
}

TEST_P(OutcomesOverLossyMedia, ThatSayNotStartedAreKept) {
  const auto robot = connect(lab_);
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  const auto first = robot.set(1);
  ASSERT_EQ(first.wait(), State::Finished);
  const CommandId next{first.id().incarnation, first.id().session, first.id().counter + 1};
  ASSERT_EQ(ask(next).detail, Detail::NotStarted);
  const auto late = robot.set(2);
  ASSERT_EQ(late.id(), next);
  EXPECT_EQ(late.get().error().detail, Detail::NotStarted);
  EXPECT_EQ(robot.read().get().value(), 1) << "it was told that 2 would never be set";
  EXPECT_EQ(robot.set(3).get().value(), 3);
}

TEST_P(Outcomes, OfAnotherLifeOfTheServerAreUnknown) {
  const auto outcome = ask({1, 2, 3});
  EXPECT_EQ(outcome.detail, Detail::OutcomeUnknown);
  EXPECT_NE(outcome.text.find("was restarted"), std::string::npos) << outcome.text;
}

TEST_P(Outcomes, OfWhatWasNeverSentAreItsOwn) {
  const probe::Probe nobody;
  const auto unsent = nobody.set(1);
  EXPECT_EQ(unsent.id(), CommandId{});
  EXPECT_EQ(gecos::outcome(connect(lab_), unsent.id()).get().error().detail, Detail::BadParameter);
}

TEST(CommandIds, AreTextAndBack) {
  const CommandId id{0x123456789abcdef0, 0xfedc, 17};
  EXPECT_EQ(gecos::to_string(id), "123456789abcdef0-fedc-11");
  EXPECT_EQ(gecos::command_id_from(gecos::to_string(id)), id);
  for (const char* wrong :
       {"", "1-2", "1-2-3-4", "1-2-x", "1-2-3 ", "-1-2-3", "11111111111111111-2-3"}) {
    EXPECT_FALSE(gecos::command_id_from(wrong)) << wrong;
  }
}

}  // namespace
