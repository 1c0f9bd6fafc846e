// Who may command: leases through sessions, over every medium.
#include <unistd.h>

#include <condition_variable>
#include <future>
#include <latch>
#include <memory>
#include <mutex>

#include "await_detail.hpp"
#include "gecos/binding.hpp"
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

TEST_P(Leases, AreDeniedWithAnAdviceToASecondProxyOfTheProgram) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  const auto lease = *gecos::actor(first);
  const auto refused = second.set(1).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Denied);
  EXPECT_NE(refused.error().text.find("; another proxy of the same program holds the status: "
                                      "call through that proxy, or through a copy"),
            std::string::npos)
      << refused.error();
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

/// Acquires actor status on a thread of its own, waiting in line, and keeps each place that it was
/// told.
class Waiter {
 public:
  Waiter(const probe::Probe& robot, gecos::LeaseOptions options) {
    options.on_position = [this](std::uint32_t before) {
      const std::lock_guard lock(mutex_);
      places_.push_back(before);
      changed_.notify_all();
    };
    lease_ =
        std::async(std::launch::async, [robot, options] { return gecos::actor(robot, options); });
  }
  void await_place(std::uint32_t before) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !places_.empty() && places_.back() == before; });
  }
  gecos::Checked<gecos::Lease, gecos::LeaseRefusal> lease() { return lease_.get(); }
  bool waits() const {
    return lease_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  }
  std::vector<std::uint32_t> places() {
    const std::lock_guard lock(mutex_);
    return places_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint32_t> places_;
  std::future<gecos::Checked<gecos::Lease, gecos::LeaseRefusal>> lease_;
};

const gecos::LeaseOptions patient{.timeout = std::chrono::minutes(5)};

TEST_P(Leases, AreWaitedForInTheOrderOfArrivalAndTellThePlace) {
  gecos::Lab third_lab(probe::patient());
  const auto holder = connect(lab_);
  auto held = gecos::actor(holder);
  ASSERT_TRUE(held) << held.error();
  Waiter first(connect(second_lab_), patient);
  first.await_place(0);
  Waiter second(connect(third_lab), patient);
  second.await_place(1);
  held->release();
  auto got = first.lease();
  ASSERT_TRUE(got) << got.error();
  second.await_place(0);
  EXPECT_TRUE(second.waits());
  got->release();
  EXPECT_TRUE(second.lease());
  EXPECT_EQ(second.places(), (std::vector<std::uint32_t>{1, 0}));
}

TEST_P(Leases, AreGrantedToTheLineOnlyWhenTheLastCommandHasEnded) {
  const auto first = connect(lab_);
  auto held = gecos::actor(first);
  ASSERT_TRUE(held) << held.error();
  const auto move = first.move(1);
  servant_.await_moves(1);
  Waiter next(connect(second_lab_), patient);
  next.await_place(0);
  held->release();
  EXPECT_FALSE(gecos::actor(first)) << "who has released it comes after those who wait";
  EXPECT_TRUE(next.waits());
  servant_.open_gate();
  EXPECT_TRUE(next.lease());
  EXPECT_TRUE(move.get());
}

TEST_P(Leases, AreGrantedToTheLineWhenTheirHolderIsGone) {
  auto gone = std::make_unique<gecos::Lab>(probe::patient());
  auto held = gecos::actor(connect(*gone));
  ASSERT_TRUE(held) << held.error();
  Waiter next(connect(second_lab_), patient);
  next.await_place(0);
  gone->close();
  EXPECT_TRUE(next.lease());
}

TEST_P(Leases, AreRefusedWhenTheWaitIsOver) {
  const auto held = gecos::actor(connect(lab_));
  ASSERT_TRUE(held) << held.error();
  const auto refused =
      gecos::actor(connect(second_lab_), {.timeout = std::chrono::milliseconds(50)});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().holders.size(), 1u);
  EXPECT_NE(
      refused.error().failure.text.find("the request waited 0.05 s, with 0 requests before it"),
      std::string::npos)
      << refused.error();
}

TEST_P(Leases, AreNotWaitedForAfterAStop) {
  const auto held = gecos::actor(connect(lab_));
  ASSERT_TRUE(held) << held.error();
  Waiter next(connect(second_lab_), patient);
  next.await_place(0);
  ASSERT_TRUE(gecos::stop(connect(lab_)).get());
  const auto refused = next.lease();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().failure.detail, Detail::Stopped) << refused.error();
}

TEST_P(Leases, AreNotGivenToAProgramThatHasLeftTheLine) {
  gecos::Lab third_lab(probe::patient());
  auto held = gecos::actor(connect(lab_));
  ASSERT_TRUE(held) << held.error();
  const auto impatient = connect(second_lab_);
  const auto asked = gecos::session::ask_for_status(*session_of(impatient), gecos::Status::ACTOR,
                                                    {}, std::chrono::minutes(5));
  probe::await_detail(gecos::Command<void>(asked), Detail::Queued);
  Waiter next(connect(third_lab), patient);
  next.await_place(1);
  gecos::session::decline_status(session_of(impatient), asked);
  next.await_place(0);
  EXPECT_EQ(gecos::Command<void>(asked).get().error().detail, Detail::Canceled);
  held->release();
  EXPECT_TRUE(next.lease());
}

TEST_P(Leases, ThatAreGrantedToAProgramThatLeavesAreReleased) {
  const auto robot = connect(lab_);
  const auto asked =
      gecos::session::ask_for_status(*session_of(robot), gecos::Status::ACTOR, {}, {});
  ASSERT_TRUE(gecos::Command<void>(asked).get());
  gecos::session::decline_status(session_of(robot), asked);
  EXPECT_TRUE(gecos::actor(connect(second_lab_), patient)) << "as soon as it is released";
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

TEST_P(Leases, OfAMasterLeaveTheStreamsThatOthersReadAsTheyAreAndAllowNoNewOnes) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  auto level = second.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto next = [&level] {
    const auto sample = level->next(std::chrono::seconds(10));
    return sample ? sample->value : -1;
  };
  servant_.publish(1);
  ASSERT_EQ(next(), 1);
  auto lease = gecos::master(first);
  ASSERT_TRUE(lease) << lease.error();
  servant_.publish(2);
  EXPECT_EQ(next(), 2);

  gecos::Lab third_lab(probe::patient());
  const auto third = connect(third_lab);
  const auto refused = third.level(gecos::stream);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Denied) << refused.error();
  EXPECT_NE(refused.error().text.find("is refused while another client is master"),
            std::string::npos)
      << refused.error();
  lease->release();
  auto later = third.level(gecos::stream);
  ASSERT_TRUE(later) << later.error();
  servant_.publish(3);
  EXPECT_EQ(next(), 3) << "the end of the master status changes nothing either";
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

TEST_P(Leases, OfAMasterEndWhenAnybodyStopsTheDevice) {
  const auto first = connect(lab_);
  const auto second = connect(second_lab_);
  const auto lease = gecos::master(first);
  ASSERT_TRUE(lease) << lease.error();
  const auto move = first.move(1);
  servant_.await_moves(1);
  EXPECT_EQ(gecos::holders(second).get().value().size(), 1u);
  ASSERT_TRUE(gecos::stop(second).get());
  EXPECT_EQ(move.get().error().detail, Detail::Stopped);
  EXPECT_EQ(first.set(2).get().error().detail, Detail::Stopped);
  EXPECT_EQ(second.read().get().value(), 7) << "nobody is master any more";
}

TEST_P(Leases, EndWhenAnybodyStopsADeviceWhoseQueueIsFull) {
  std::vector<std::unique_ptr<gecos::Lab>> labs;
  std::vector<gecos::Lease> leases;
  std::vector<gecos::Command<std::int32_t>> open;
  for (int client = 0; client < 5; ++client) {
    labs.push_back(std::make_unique<gecos::Lab>(probe::patient()));
    const auto robot = connect(*labs.back());
    auto lease = gecos::actor(robot, "many hands");
    ASSERT_TRUE(lease) << lease.error();
    leases.push_back(std::move(*lease));
    if (client == 0) open.push_back(robot.move(1));
    servant_.await_moves(1);
    for (int at = 0; at < 60; ++at) open.push_back(robot.set(at));
  }
  EXPECT_EQ(open.back().get().error().detail, Detail::QueueFull) << "256 wait at the object";
  ASSERT_TRUE(gecos::stop(connect(second_lab_)).get());
  for (std::size_t at = 0; at < 1 + 4 * 60; ++at) {
    EXPECT_EQ(open[at].get().error().detail, Detail::Stopped) << at;
  }
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
