#include "gecos/session/client/lease_state.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

TEST(LeaseState, HasNoEpochWithoutALease) { EXPECT_EQ(LeaseState().epoch(), Epoch{}); }

TEST(LeaseState, HasNoEpochAfterTheLastLeaseOfTheStatus) {
  LeaseState state;
  const auto first = state.acquired(5);
  const auto second = state.acquired(5);
  state.released(first);
  EXPECT_EQ(state.epoch(), Epoch{5});
  state.released(second);
  EXPECT_EQ(state.epoch(), Epoch{});
}

TEST(LeaseState, KeepsTheNewerStatusWhenALeaseOfAnOlderOneIsReleased) {
  LeaseState state;
  const auto older = state.acquired(5);
  EXPECT_FALSE(state.lost(older));
  const auto newer = state.acquired(6);
  EXPECT_TRUE(state.lost(older));
  EXPECT_FALSE(state.lost(newer));
  state.released(older);
  EXPECT_EQ(state.epoch(), Epoch{6});
  state.released(newer);
  EXPECT_EQ(state.epoch(), Epoch{});
}

TEST(LeaseState, TakesTheEpochOfARenewedStatusOnlyWhileALeaseIsHeld) {
  LeaseState state;
  state.renewed(Epoch{5});
  EXPECT_EQ(state.epoch(), Epoch{});
  const auto held = state.acquired(5);
  state.renewed(Epoch{7});
  EXPECT_EQ(state.epoch(), Epoch{7});
  EXPECT_FALSE(state.lost(held));
  state.renewed(Epoch{6});
  EXPECT_EQ(state.epoch(), Epoch{7}) << "the reply was sent before, and came late";
  state.released(held);
  EXPECT_EQ(state.epoch(), Epoch{});
}

}  // namespace
}  // namespace gecos::session
