// Who holds the status of an object, and each change of that, told to others and holders.
#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::HolderChange;

/// `other` observes, and holds no status.
class Rosters : public probe::TwoProxies {
 protected:
  gecos::Roster roster(std::uint64_t after = 0, gecos::Duration timeout = 60s) {
    const auto told = gecos::roster(other, after, timeout).get();
    EXPECT_TRUE(told) << told.error();
    return told.value_or(gecos::Roster());
  }
  static std::vector<HolderChange> kinds(const gecos::Roster& roster) {
    std::vector<HolderChange> found;
    for (const auto& change : roster.changes) found.push_back(change.what);
    return found;
  }
  using Kinds = std::vector<HolderChange>;
};
PROBE_OVER_MEDIA(Rosters);

TEST_P(Rosters, AreToldAtOnceAtFirst) {
  const gecos::Roster nobody = roster();
  EXPECT_TRUE(nobody.holders.empty());
  EXPECT_TRUE(nobody.changes.empty());
  EXPECT_NE(nobody.newest, 0u);
  const auto lease = gecos::actor(holder);
  ASSERT_TRUE(lease);
  const gecos::Roster one = roster();
  ASSERT_EQ(one.holders.size(), 1u);
  EXPECT_EQ(one.holders[0].pid, getpid());
  EXPECT_EQ(one.newest, nobody.newest + 1);
}

TEST_P(Rosters, AreToldWhenTheyChange) {
  const std::uint64_t known = roster().newest;
  const auto told = gecos::roster(other, known, 60s);
  ASSERT_TRUE(other.read().get()) << "the server has the question";
  const auto lease = gecos::master(holder);
  ASSERT_TRUE(lease);
  const auto changed = told.get();
  ASSERT_TRUE(changed) << changed.error();
  ASSERT_EQ(changed->changes.size(), 1u);
  const gecos::RosterChange& change = changed->changes[0];
  EXPECT_EQ(change.number, known + 1);
  EXPECT_EQ(change.what, HolderChange::ACQUIRED);
  EXPECT_EQ(change.holder.status, gecos::Status::MASTER);
  EXPECT_EQ(change.holder.pid, getpid());
  EXPECT_GE(change.ago, 0);
  EXPECT_EQ(changed->newest, known + 1);
}

TEST_P(Rosters, TellEachChangeOnceThoughNobodyAskedMeanwhile) {
  const std::uint64_t known = roster().newest;
  {
    const auto lease = gecos::actor(holder, "two hands");
    ASSERT_TRUE(lease);
    ASSERT_TRUE(gecos::take_over(holder).get());
    ASSERT_TRUE(gecos::give_back(holder).get());
  }
  const gecos::Roster told = roster(known);
  EXPECT_EQ(kinds(told), Kinds({HolderChange::ACQUIRED, HolderChange::TAKEN_OVER,
                                HolderChange::GIVEN_BACK, HolderChange::ENDED}));
  EXPECT_TRUE(told.holders.empty());
  EXPECT_EQ(told.changes.back().why, "released");
  EXPECT_EQ(kinds(roster(told.newest - 1)), Kinds({HolderChange::ENDED}));
  EXPECT_TRUE(roster(told.newest, 0s).changes.empty());
}

TEST_P(Rosters, TellTheLastCommandsOfAHolderThatReleases) {
  auto lease = gecos::actor(holder);
  ASSERT_TRUE(lease);
  const std::uint64_t known = roster().newest;
  const auto move = holder.move(1);
  servant_.await_moves(1);
  lease->release();
  const gecos::Roster releasing = roster(known);
  EXPECT_EQ(kinds(releasing), Kinds({HolderChange::RELEASING}));
  servant_.open_gate();
  EXPECT_EQ(move.wait(), gecos::State::Finished);
  EXPECT_EQ(kinds(roster(releasing.newest)), Kinds({HolderChange::ENDED}));
}

TEST_P(Rosters, TellWhoStoppedTheObject) {
  const auto lease = gecos::actor(holder);
  ASSERT_TRUE(lease);
  const std::uint64_t known = roster().newest;
  ASSERT_TRUE(gecos::stop(other).get());
  const gecos::Roster told = roster(known);
  ASSERT_EQ(kinds(told), Kinds({HolderChange::ENDED}));
  EXPECT_TRUE(told.changes[0].why.starts_with("stopped by ")) << told.changes[0].why;
}

TEST_P(Rosters, EndTheQuestionOfAClientThatCancels) {
  auto told = gecos::roster(other, roster().newest, 3600s);
  ASSERT_TRUE(other.read().get()) << "the server has the question";
  told.cancel();
  EXPECT_EQ(told.get().error().detail, Detail::Canceled);
}

}  // namespace

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

class QuestionsAboutTheRoster : public ServedObjects {
 protected:
  void ask(std::uint64_t counter, std::uint64_t after, double patience) {
    const GecosObject_roster_arguments asked{after, patience};
    call(counter, GecosObjectInterface::roster.code, layout::to_bytes(asked));
  }
  Roster roster() {
    ask(1000, 0, 0);
    const auto packet = wire::decode_packet(connection_->sent.back());
    auto told = layout::from_bytes<GecosObject_roster_result>(packet->body);
    EXPECT_TRUE(told);
    return told ? std::move(told->result) : Roster();
  }
  std::uint64_t newest() { return roster().newest; }
};

TEST_F(QuestionsAboutTheRoster, AreToldWhyAStatusWasLost) {
  acquire(1);
  object_->depart(session_, ObjectHost::Departure::Lost);
  connect();
  const Roster told = roster();
  EXPECT_TRUE(told.holders.empty());
  ASSERT_EQ(told.changes.size(), 2u);
  EXPECT_EQ(told.changes[0].what, HolderChange::ACQUIRED);
  EXPECT_EQ(told.changes[1].what, HolderChange::ENDED);
  EXPECT_TRUE(told.changes[1].why.starts_with("its holder (")) << told.changes[1].why;
}

TEST_F(QuestionsAboutTheRoster, AreToldThatAHolderWasSilent) {
  acquire(1);
  for (int tick = 0; tick < 100; ++tick) {
    clock_.pass(100ms);
    connection_->silent = true;
    object_->on_tick(clock_.now());
  }
  const Roster told = roster();
  ASSERT_EQ(told.changes.size(), 2u);
  EXPECT_TRUE(told.changes[1].why.starts_with("its holder has been silent for "))
      << told.changes[1].why;
  EXPECT_GT(told.changes[1].ago, 1);
}

TEST_F(QuestionsAboutTheRoster, AreAnsweredAfterTheirPatience) {
  ask(1, newest(), 60);
  clock_.pass(59s);
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), std::nullopt);
  clock_.pass(2s);
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(QuestionsAboutTheRoster, AreAnsweredAtOnceWhenTheNumberIsOfAnotherObject) {
  ask(1, newest() + 1, 60);
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(QuestionsAboutTheRoster, AreAnsweredWithTheEndOfTheObjectAndForgottenWithTheirSession) {
  ask(1, newest(), 60);
  const std::weak_ptr<ServerSession> before = session_;
  object_->depart(session_, ObjectHost::Departure::Lost);
  connect();
  EXPECT_TRUE(before.expired());
  ask(1, newest(), 60);
  EXPECT_EQ(reply_to(1), std::nullopt);
  object_->close();
  EXPECT_EQ(reply_to(1), Detail::Done);
}

}  // namespace
}  // namespace gecos::session
