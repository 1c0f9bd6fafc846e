// A handler that takes longer than it should holds up its own callers and nobody else.
#include <latch>
#include <thread>

#include "bench.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::State;

class SlowHandler : public probe::Bench {
 protected:
  void TearDown() override { server_.reset(); }  // before the servant that only this test has

  /// Returns a handler that tells `inside` that it has begun, and waits for `leave`.
  static auto held_up_by(std::latch& inside, std::latch& leave) {
    return [&inside, &leave](gecos::IncomingCall call) {
      inside.count_down();
      leave.wait();
      call.fail(gecos::Fault::rejected("slowly").failure());
    };
  }

  probe::ProbeServant slow_;
};

TEST_F(SlowHandler, DelaysNobodyAtAnotherObjectHoweverOftenItHappens) {
  serve("SLOW", slow_);
  serve("QUICK", servant_);
  const auto slow_probe = connect(lab_, "SLOW");
  const auto quick_probe = connect(second_lab_, "QUICK");
  for (int round = 0; round < 3; ++round) {
    std::latch inside(1);
    std::latch leave(1);
    slow_.on_read(held_up_by(inside, leave));
    ASSERT_TRUE(quick_probe.read().get()) << "so that its connection is looked at, not slept on";
    const auto held_up = slow_probe.read();
    inside.wait();
    EXPECT_EQ(quick_probe.read().wait_for(5s), State::Finished) << "round " << round;
    EXPECT_EQ(held_up.state(), State::Running);
    leave.count_down();
    EXPECT_EQ(held_up.wait(), State::CommandFailed);
  }
}

TEST_F(SlowHandler, DelaysNobodyAfterTheServerHasRested) {
  serve("SLOW", slow_);
  serve("QUICK", servant_);
  const auto slow_probe = connect(lab_, "SLOW");
  const auto quick_probe = connect(second_lab_, "QUICK");
  std::latch inside(1);
  std::latch leave(1);
  slow_.on_read(held_up_by(inside, leave));
  ASSERT_TRUE(quick_probe.read().get());
  std::this_thread::sleep_for(400ms);  // no synchronisation: the test needs a server that rests
  const auto held_up = slow_probe.read();
  inside.wait();
  EXPECT_EQ(quick_probe.read().wait_for(5s), State::Finished);
  leave.count_down();
  EXPECT_EQ(held_up.wait(), State::CommandFailed);
}

TEST_F(SlowHandler, DelaysNobodyAtAThirdObjectWhenTwoAreSlowAtOnce) {
  serve("SLOW", slow_);
  probe::ProbeServant slow_too;
  serve("SLOW_TOO", slow_too);
  serve("QUICK", servant_);
  std::latch inside(2);
  std::latch leave(1);
  const auto slowly = held_up_by(inside, leave);
  slow_.on_read(slowly);
  slow_too.on_read(slowly);
  const auto one = connect(lab_, "SLOW").read();
  const auto other = connect(lab_, "SLOW_TOO").read();
  inside.wait();
  const auto quick_probe = connect(second_lab_, "QUICK");
  EXPECT_EQ(quick_probe.read().wait_for(5s), State::Finished);
  EXPECT_EQ(gecos::stop(quick_probe).wait_for(5s), State::Finished);
  leave.count_down();
  EXPECT_EQ(one.wait(), State::CommandFailed);
  EXPECT_EQ(other.wait(), State::CommandFailed);
  server_.reset();
}

}  // namespace
