// One of several programs that share a status takes over, through sessions, over every medium.
#include <algorithm>

#include "await_detail.hpp"
#include "over_media.hpp"

namespace {

using gecos::Detail;
using gecos::State;

/// `mover` and `guard` share actor status by password.
class TakeOvers : public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    mover = connect(lab_);
    guard = connect(second_lab_);
    movers.emplace(*gecos::actor(mover, "two hands"));
    guards.emplace(*gecos::actor(guard, "two hands"));
  }
  static std::string refusal(const gecos::Command<void>& command) {
    const auto got = command.get();
    if (got) return "none";
    EXPECT_TRUE(got.error().as<gecos::StatusRefused>()) << got.error();
    return got.error().text;
  }

  probe::Probe mover, guard;
  std::optional<gecos::Lease> movers, guards;
};
PROBE_OVER_MEDIA(TakeOvers);

TEST_P(TakeOvers, EndWhatTheOthersRunAndQueueAndRefuseWhatTheyIssue) {
  const auto runs = mover.move(1);
  const auto waits = mover.set(2);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::take_over(guard).get());
  for (const auto& command : {runs, waits}) {
    const auto ended = command.get();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, Detail::Preempted) << ended.error();
    EXPECT_NE(ended.error().text.find(" over"), std::string::npos) << ended.error();
    EXPECT_NE(ended.error().text.find("pid " + std::to_string(getpid())), std::string::npos);
  }
  servant_.await_event("interrupted 1");
  const auto refused = mover.set(3).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Denied) << refused.error();
  EXPECT_NE(refused.error().text.find("is held off: "), std::string::npos) << refused.error();
  EXPECT_EQ(mover.read().get().value(), 7) << "reading goes on";
  EXPECT_EQ(guard.set(4).get().value(), 4);

  ASSERT_TRUE(gecos::give_back(guard).get());
  EXPECT_EQ(mover.set(5).get().value(), 5);
  EXPECT_EQ(guard.set(6).get().value(), 6) << "the taker is a member as before";
  EXPECT_EQ(servant_.events(),
            (std::vector<std::string>{"start 1", "interrupted 1", "set 4", "set 5", "set 6"}))
      << "nothing resumes by itself";
}

TEST_P(TakeOvers, LetTheTakersOwnCommandsGoOn) {
  const auto move = guard.move(1);
  const auto set = guard.set(2);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::take_over(guard).get());
  servant_.open_gate();
  EXPECT_EQ(move.wait(), State::Finished);
  EXPECT_EQ(set.get().value(), 2);
}

TEST_P(TakeOvers, RefuseWhatAnIdleProgramIssuesBeforeItIsToldOfThem) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  ASSERT_TRUE(gecos::give_back(guard).get());
  const auto issued_before = mover.set(1).get();
  ASSERT_FALSE(issued_before) << "the device may be elsewhere now";
  EXPECT_EQ(issued_before.error().detail, Detail::Preempted);
  EXPECT_NE(issued_before.error().text.find("check where the device is, and command again"),
            std::string::npos)
      << issued_before.error();
  EXPECT_EQ(mover.set(2).get().value(), 2);

  ASSERT_TRUE(gecos::take_over(guard).get());
  ASSERT_TRUE(gecos::give_back(guard).get());
  ASSERT_EQ(mover.read().get().value(), 2);
  EXPECT_EQ(mover.set(3).get().value(), 3) << "a reading tells, too";
}

TEST_P(TakeOvers, AreForOneAtATimeAndForHoldersOnly) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  ASSERT_TRUE(gecos::take_over(guard).get()) << "a second one changes nothing";
  const std::string second = refusal(gecos::take_over(mover));
  EXPECT_NE(
      second.find("has taken over; wait until it gives sole command back, or stop the object"),
      std::string::npos)
      << second;
  gecos::Lab third_lab(probe::patient());
  const std::string stranger = refusal(gecos::take_over(connect(third_lab)));
  EXPECT_TRUE(
      stranger.starts_with("PROBE: take-over refused: this client does not hold the status"))
      << stranger;
  ASSERT_TRUE(gecos::give_back(mover).get()) << "does nothing";
  EXPECT_EQ(mover.set(1).get().error().detail, Detail::Denied);
}

TEST_P(TakeOvers, AreShownAmongTheHolders) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  gecos::Lab third_lab(probe::patient());
  const auto seen = gecos::holders(connect(third_lab)).get();
  ASSERT_TRUE(seen) << seen.error();
  ASSERT_EQ(seen->size(), 2u);
  EXPECT_EQ(std::ranges::count_if(*seen, &gecos::Holder::taken_over), 1);
  ASSERT_TRUE(gecos::give_back(guard).get());
  const auto after = gecos::holders(mover).get();
  ASSERT_TRUE(after) << after.error();
  EXPECT_EQ(std::ranges::count_if(*after, &gecos::Holder::taken_over), 0);
}

TEST_P(TakeOvers, EndWithTheReleaseOfTheTakersLastCommand) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  const auto retreat = guard.move(1);
  servant_.await_moves(1);
  guards->release();
  ASSERT_TRUE(mover.read().get());  // tells it of the take-over
  EXPECT_EQ(mover.set(1).get().error().detail, Detail::Denied) << "the last command still runs";
  servant_.open_gate();
  EXPECT_EQ(retreat.wait(), State::Finished);
  EXPECT_EQ(mover.set(2).get().value(), 2);
}

TEST_P(TakeOvers, EndWhenTheTakerReleasesAtOnce) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  const auto retreat = guard.move(1);
  servant_.await_moves(1);
  guards->release_now();
  EXPECT_EQ(retreat.get().error().detail, Detail::Stopped);
  ASSERT_TRUE(mover.read().get());
  EXPECT_EQ(mover.set(2).get().value(), 2);
}

TEST_P(TakeOvers, AreKeptByATakerThatStops) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  ASSERT_TRUE(gecos::stop(guard).get());
  EXPECT_EQ(guard.set(1).get().value(), 1);
  EXPECT_EQ(mover.set(2).get().error().detail, Detail::Stopped);
  const auto again = gecos::actor(mover, "two hands");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(mover.set(3).get().error().detail, Detail::Denied) << "a new member is held off, too";
  ASSERT_TRUE(gecos::give_back(guard).get());
  EXPECT_EQ(mover.set(4).get().value(), 4);
}

TEST_P(TakeOvers, EndWhenAnotherMemberStops) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  const auto retreat = guard.move(1);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::stop(mover).get());
  EXPECT_EQ(retreat.get().error().detail, Detail::Stopped);
  EXPECT_EQ(mover.set(2).get().value(), 2);
  EXPECT_EQ(guard.set(3).get().error().detail, Detail::Stopped);
}

TEST_P(TakeOvers, LeaveNestedLeasesOfTheOthersAsTheyAre) {
  ASSERT_TRUE(gecos::take_over(guard).get());
  ASSERT_TRUE(gecos::give_back(guard).get());
  {
    const auto inner = gecos::actor(mover, "two hands");
    ASSERT_TRUE(inner) << inner.error();
    EXPECT_EQ(mover.set(1).get().value(), 1) << "the grant tells, too";
  }
  EXPECT_FALSE(movers->lost());
  EXPECT_EQ(mover.set(2).get().value(), 2);
  movers->release();
  guards->release();
  EXPECT_TRUE(gecos::actor(mover)) << "releasing works under the newer epoch";
}

}  // namespace
