#include "gecos/session/client/idle_rest.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

TEST(IdleRest, BeginsAtTheFirstTickWithoutAnOpenOrNewCall) {
  IdleRest rest;
  EXPECT_FALSE(rest.rests());
  EXPECT_TRUE(rest.tick(0, 0));
  EXPECT_TRUE(rest.rests());
  EXPECT_FALSE(rest.tick(1, 1)) << "a call is open";
  EXPECT_TRUE(rest.tick(1, 0));
  EXPECT_FALSE(rest.tick(2, 0)) << "a call has begun and ended since the last tick";
  EXPECT_FALSE(rest.rests());
  EXPECT_TRUE(rest.tick(2, 0));
}

TEST(IdleRest, EndsWithTheFirstCallAlone) {
  IdleRest rest;
  EXPECT_FALSE(rest.call_sent()) << "the thread does not rest";
  EXPECT_FALSE(rest.take_tick_request());
  EXPECT_FALSE(rest.tick(1, 0));
  EXPECT_TRUE(rest.tick(1, 0));
  EXPECT_TRUE(rest.call_sent());
  EXPECT_FALSE(rest.call_sent());
  EXPECT_TRUE(rest.take_tick_request());
  EXPECT_FALSE(rest.take_tick_request());
}

}  // namespace
}  // namespace gecos::session
