// Who may command: leases through sessions, over every medium.
#include <unistd.h>

#include <future>
#include <latch>

#include "await_detail.hpp"
#include "over_media.hpp"

namespace {

using gecos::Detail;
using gecos::State;

class Leases : public probe::OverMedia {};
PROBE_OVER_MEDIA(Leases);

TEST_P(Leases, AreRefusedToASecondProgramWithTheHolderNamed) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  const auto lease = gecos::actor(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto refused = gecos::actor(second);
  ASSERT_FALSE(refused);
  ASSERT_EQ(refused.error().holders.size(), 1u);
  EXPECT_EQ(refused.error().holders[0].pid, getpid());
  EXPECT_EQ(refused.error().holders[0].status, gecos::Status::ACTOR);
  EXPECT_NE(refused.error().failure.text.find("actor status is held by"), std::string::npos)
      << refused.error();
  EXPECT_EQ(gecos::holders(second).get().value().size(), 1u);
}

TEST_P(Leases, AreFreeAgainWhenReleased) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  {
    const auto lease = gecos::actor(first);
    ASSERT_TRUE(lease) << lease.error();
  }
  EXPECT_TRUE(gecos::actor(second));
  const auto set = first.set(1).get();
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().detail, Detail::Denied) << "nothing was lost: it was given back";
}

TEST_P(Leases, OfOneSessionCountEachTheirOwn) {
  const auto robot = connect(lab_);
  auto outer = gecos::actor(robot);
  ASSERT_TRUE(outer) << outer.error();
  {
    const auto inner = gecos::actor(robot);
    ASSERT_TRUE(inner) << inner.error();
  }
  EXPECT_EQ(robot.set(1).get().value(), 1);
  outer->release();
  EXPECT_EQ(robot.set(2).get().error().detail, Detail::Denied);
}

TEST_P(Leases, OfAStatusThatWasLostDoNotTakeItsSuccessorAlong) {
  const auto robot = connect(lab_);
  auto lost = gecos::actor(robot);
  ASSERT_TRUE(lost) << lost.error();
  ASSERT_TRUE(gecos::stop(connect(second_lab_)).get());
  const auto held = gecos::actor(robot);
  ASSERT_TRUE(held) << held.error();
  lost->release();
  EXPECT_EQ(robot.set(1).get().value(), 1);
}

TEST_P(Leases, AreSharedByPassword) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  const auto lease = gecos::actor(first, "open sesame");
  ASSERT_TRUE(lease) << lease.error();
  EXPECT_FALSE(gecos::actor(second));
  EXPECT_FALSE(gecos::actor(second, "close sesame"));
  const auto joined = gecos::actor(second, "open sesame");
  ASSERT_TRUE(joined) << joined.error();
  EXPECT_EQ(first.set(1).get().value(), 1);
  EXPECT_EQ(second.set(2).get().value(), 2);
}

TEST_P(Leases, DrainWhenReleasedSoThatWhatWasIssuedStillRuns) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  auto lease = gecos::actor(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = first.move(1);
  const auto set = first.set(2);
  servant_.await_moves(1);
  lease->release();
  EXPECT_EQ(first.set(3).get().error().detail, Detail::Denied);
  const auto refused = gecos::actor(second);
  ASSERT_FALSE(refused) << "its last commands are still running";
  ASSERT_EQ(refused.error().holders.size(), 1u);
  EXPECT_TRUE(refused.error().holders[0].releasing);
  servant_.open_gate();
  EXPECT_EQ(move.wait(), State::Finished);
  EXPECT_EQ(set.wait(), State::Finished);
  EXPECT_TRUE(gecos::actor(second)) << "free as soon as its last command has ended";
}

TEST_P(Leases, StopWhatRunsWhenReleasedAtOnce) {
  const auto first = connect(lab_);
  auto lease = gecos::actor(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = first.move(1);
  const auto set = first.set(2);
  servant_.await_moves(1);
  lease->release_now();
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);
  EXPECT_EQ(set.get().error().detail, Detail::Stopped);
  servant_.await_event("interrupted 1");
  EXPECT_TRUE(gecos::actor(connect(second_lab_)));
}

TEST_P(Leases, AreNotGrantedWhileAHandlerOfTheLastHolderStillRuns) {
  std::latch leave(1);
  servant_.on_move([&] { leave.wait(); });  // deaf to every interruption
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  auto lease = gecos::actor(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = first.move(1);
  servant_.await_moves(1);
  lease->release_now();
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);

  const auto refused = gecos::actor(second);
  auto granted = std::async([&] {
    auto got = gecos::actor(second);
    return std::pair(got.has_value(), servant_.events());
  });
  leave.count_down();
  const auto [held, events] = granted.get();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().failure.text.find("the handler of 'move' still runs"),
            std::string::npos)
      << refused.error();
  ASSERT_EQ(refused.error().holders.size(), 1u);
  EXPECT_EQ(refused.error().holders[0].pid, getpid());
  EXPECT_TRUE(held) << "as soon as it has returned";
  EXPECT_EQ(events, (std::vector<std::string>{"start 1", "interrupted 1"}));
}

TEST_P(Leases, DrainWhenTheProgramEndsInOrderWithoutWaiting) {
  {
    gecos::Lab lab(probe::patient());
    const auto robot = connect(lab);
    const auto lease = gecos::actor(robot);
    ASSERT_TRUE(lease) << lease.error();
    static_cast<void>(robot.move(1));
    static_cast<void>(robot.set(2));
  }
  servant_.await_moves(1);
  servant_.open_gate();
  servant_.await_event("set 2");
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "end 1", "set 2"}));
}

TEST_P(Leases, OfAMasterRefuseEverybodyElse) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  const auto lease = gecos::master(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto read = second.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::Denied);
  EXPECT_EQ(first.read().get().value(), 7);
  EXPECT_TRUE(gecos::ping(second).get()) << "what every object answers is always answered";
  EXPECT_TRUE(gecos::describe(second).get());
}

TEST_P(Leases, EndWhenAnybodyStopsTheDevice) {
  const auto mover = connect(lab_);
  const auto other = connect(second_lab_);
  const auto lease = gecos::actor(mover);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = mover.move(1);
  const auto set = mover.set(2);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::stop(other).get());
  const auto stopped = move.get();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().detail, Detail::Stopped);
  EXPECT_NE(stopped.error().text.find("pid " + std::to_string(getpid())), std::string::npos);
  EXPECT_EQ(set.get().error().detail, Detail::Stopped) << "also when it arrived after the stop";
  servant_.await_event("interrupted 1");
  const auto later = mover.set(3).get();
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().detail, Detail::Stopped);
  EXPECT_NE(later.error().text.find("pid " + std::to_string(getpid())), std::string::npos)
      << later.error();
  EXPECT_TRUE(gecos::actor(other)) << "there is no reset: status may be acquired at once";
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "interrupted 1"}));
}

TEST_P(Leases, GoOnForAMemberThatStopsTheDeviceItself) {
  const auto mover = connect(lab_);
  auto lease = gecos::actor(mover);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = mover.move(1);
  servant_.await_moves(1);
  ASSERT_TRUE(gecos::stop(mover).get());
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);
  EXPECT_EQ(mover.set(3).get().value(), 3);
  lease->release();
  EXPECT_TRUE(gecos::actor(connect(second_lab_))) << "releasing works under the renewed epoch";
}

}  // namespace
