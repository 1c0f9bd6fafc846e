#include "gecos/session/protocol/peer_liveness.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;
using Verdict = PeerLiveness::Verdict;

constexpr TimePoint start{100s};

class PeerLivenessTest : public ::testing::Test {
 protected:
  Verdict check(Duration after) { return peer.check(heartbeats, start + after); }

  std::uint64_t heartbeats = 0;
  PeerLiveness peer{{.suspect_after = 300ms, .dead_after = 1300ms}};
};

TEST_F(PeerLivenessTest, IsAliveAtTheFirstCheckFromWhichSilenceCounts) {
  EXPECT_EQ(peer.silent_for(start + 10s), Duration::zero());
  EXPECT_EQ(check(10s), Verdict::Alive);
  EXPECT_EQ(check(10s + 299ms), Verdict::Quiet);
  EXPECT_EQ(check(10s + 300ms), Verdict::Suspect);
}

TEST_F(PeerLivenessTest, SilenceCountsFromWhenItWasHeard) {
  peer.heard(start);
  EXPECT_EQ(check(299ms), Verdict::Quiet);
  EXPECT_EQ(check(300ms), Verdict::Suspect);
  EXPECT_EQ(check(1299ms), Verdict::Suspect);
  EXPECT_EQ(check(1300ms), Verdict::Dead);
  EXPECT_EQ(peer.silent_for(start + 1300ms), 1300ms);
}

TEST_F(PeerLivenessTest, StaysAliveAsLongAsHeartbeatsCome) {
  for (int second = 0; second < 100; ++second) {
    ++heartbeats;
    EXPECT_EQ(check(second * 1s), Verdict::Alive) << "however late a check is";
  }
}

TEST_F(PeerLivenessTest, AHeartbeatIsASignOfLifeOnce) {
  heartbeats = 7;
  EXPECT_EQ(check(0s), Verdict::Alive);
  EXPECT_EQ(check(10ms), Verdict::Quiet);
  EXPECT_EQ(check(300ms), Verdict::Suspect);
}

TEST_F(PeerLivenessTest, ASuspectIsAliveAgainWithItsNextHeartbeat) {
  peer.heard(start);
  ASSERT_EQ(check(1200ms), Verdict::Suspect);
  ++heartbeats;
  EXPECT_EQ(check(1250ms), Verdict::Alive);
  EXPECT_EQ(check(1300ms), Verdict::Quiet) << "its silence before does not count any more";
}

TEST_F(PeerLivenessTest, HeartbeatsThatMustNotCountAreNoSign) {
  peer.heard(start);
  heartbeats = 3;
  peer.await_heartbeat_after(heartbeats);
  EXPECT_EQ(check(10ms), Verdict::Quiet);
  ++heartbeats;
  EXPECT_EQ(check(20ms), Verdict::Alive);
}

}  // namespace
}  // namespace gecos::session
