#include "gecos/session/client/server_watch.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

/// A server that falls silent is suspect after 800 ms and dead after 2.8 s.
class ServerWatchTest : public ::testing::Test {
 protected:
  using Verdict = PeerLiveness::Verdict;
  static LabOptions options() {
    LabOptions options;
    options.heartbeat = 100ms;
    options.lease_ttl = 1s;
    options.grace = 2s;
    return options;
  }
  Verdict after(Duration step) {
    clock.advance(step);
    return watch.judge_heartbeats(heartbeats, clock.now());
  }

  FakeClock clock;
  std::uint64_t heartbeats = 0;
  ServerWatch watch{options(), clock};
};

TEST_F(ServerWatchTest, ASilentServerIsUnreachableAndThenDead) {
  EXPECT_EQ(after(799ms), Verdict::Quiet);
  EXPECT_FALSE(watch.unreachable());
  EXPECT_EQ(after(1ms), Verdict::Suspect);
  EXPECT_TRUE(watch.unreachable());
  const TimePoint since = clock.now();
  EXPECT_EQ(after(1s), Verdict::Suspect);
  EXPECT_EQ(watch.silent_since(), since) << "when it was found unreachable";
  EXPECT_EQ(after(1s), Verdict::Dead);
  EXPECT_EQ(watch.silent_for(), 2800ms);
}

TEST_F(ServerWatchTest, LooksOftenForThePacketsOfASilentServer) {
  EXPECT_EQ(after(150ms), Verdict::Quiet);
  EXPECT_EQ(watch.next_look(clock.now()), TimePoint::max());
  EXPECT_EQ(after(1ns), Verdict::Quiet);
  EXPECT_EQ(watch.next_look(clock.now()), clock.now() + 20ms);
  ++heartbeats;
  EXPECT_EQ(after(10ms), Verdict::Alive);
  EXPECT_EQ(watch.next_look(clock.now()), TimePoint::max());
}

TEST_F(ServerWatchTest, AHeartbeatMakesTheServerReachableAgain) {
  EXPECT_EQ(after(900ms), Verdict::Suspect);
  ++heartbeats;
  EXPECT_EQ(after(10ms), Verdict::Alive);
  EXPECT_FALSE(watch.unreachable());
  EXPECT_EQ(after(10ms), Verdict::Quiet);
}

TEST_F(ServerWatchTest, CountsNoMoreThanALeaseOfAPauseInWhichThisProcessDidNotRun) {
  EXPECT_EQ(after(1h), Verdict::Suspect);
  EXPECT_EQ(watch.silent_for(), 1s);
}

TEST_F(ServerWatchTest, HowLongItIsUnheardIncludesSuchAPause) {
  after(60s);
  EXPECT_EQ(watch.unheard_for(), 60s);
  ++heartbeats;
  EXPECT_EQ(after(10ms), Verdict::Alive);
  EXPECT_EQ(watch.unheard_for(), 0s);
  EXPECT_EQ(after(50ms), Verdict::Quiet);
  EXPECT_EQ(watch.unheard_for(), 50ms);
}

TEST_F(ServerWatchTest, AServerThatSendsHeartbeatsButNoAnswersIsMute) {
  const auto next_second = [this] {
    ++heartbeats;
    EXPECT_EQ(after(1s), Verdict::Alive);
    return watch.judge_answers(true, 3);
  };
  EXPECT_EQ(next_second(), AnswerWatch::Verdict::Ask) << "the three packets are new";
  for (int second = 1; second < 6; ++second) EXPECT_EQ(next_second(), AnswerWatch::Verdict::Ask);
  EXPECT_EQ(next_second(), AnswerWatch::Verdict::Mute);
  EXPECT_EQ(watch.mute_for(), 6s);
}

}  // namespace
}  // namespace gecos::session
