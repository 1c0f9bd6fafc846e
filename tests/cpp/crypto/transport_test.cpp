#include "gecos/crypto/transport.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "channel_pair.hpp"

namespace gecos::crypto {
namespace {

using gecos::testing::bytes_of;
using gecos::testing::open_pair;
using gecos::testing::opened;
using gecos::testing::pair_opened;
using gecos::testing::sealed;
using gecos::testing::text_of;
using namespace std::chrono_literals;

TEST(Transport, CarriesPacketsBothWays) {
  auto pair = open_pair();
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "move")), "move");
  EXPECT_EQ(opened(pair.client.in, sealed(pair.server.out, "done")), "done");
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "")), "");
  EXPECT_EQ(pair.client.binding, pair.server.binding);
}

TEST(Transport, NothingOfThePacketIsReadableInTheFrame) {
  auto pair = open_pair();
  const Bytes frame = sealed(pair.client.out, "the secret words");
  EXPECT_EQ(frame.size(), 16 + Sealer::overhead);
  EXPECT_EQ(text_of(frame).find("secret"), std::string::npos);
  EXPECT_NE(text_of(sealed(pair.client.out, "same")).substr(8),
            text_of(sealed(pair.client.out, "same")).substr(8));
}

TEST(Transport, APacketIsNotAcceptedByTheSideThatSealedIt) {
  auto pair = open_pair();
  EXPECT_EQ(opened(pair.client.in, sealed(pair.client.out, "mirror")),
            "refused: the packet is not from the peer, or it was altered");
}

TEST(Transport, WhatTravelsBesideTheFrameInClearIsProtectedToo) {
  auto pair = open_pair();
  const Bytes header = bytes_of("header");
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "x", header), bytes_of("Header")),
            "refused: the packet is not from the peer, or it was altered");
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "y", header), header), "y");
}

TEST(Transport, ARepeatedPacketIsDeliveredOnceAndAnOvertakenOneStill) {
  auto pair = open_pair();
  const Bytes first = sealed(pair.client.out, "1");
  const Bytes second = sealed(pair.client.out, "2");
  EXPECT_EQ(opened(pair.server.in, second), "2");
  EXPECT_EQ(opened(pair.server.in, second), "refused: the packet was delivered already");
  EXPECT_EQ(opened(pair.server.in, first), "1");
  EXPECT_EQ(opened(pair.server.in, first), "refused: the packet was delivered already");
}

TEST(Transport, WhatAThousandOthersOvertookIsTooOld) {
  auto pair = open_pair();
  const Bytes late = sealed(pair.client.out, "late");
  const Bytes in_time = sealed(pair.client.out, "in time");
  for (std::uint64_t i = 0; i < ReplayWindow::size - 1; ++i) {
    ASSERT_EQ(opened(pair.server.in, sealed(pair.client.out, "x")), "x");
  }
  EXPECT_EQ(opened(pair.server.in, late), "refused: the packet is too old");
  EXPECT_EQ(opened(pair.server.in, in_time), "in time");
}

TEST(Transport, AForgedPacketSpoilsNothing) {
  auto pair = open_pair();
  const Bytes frame = sealed(pair.client.out, "right");
  Bytes forged = frame;
  forged.back() ^= std::byte{1};
  EXPECT_EQ(opened(pair.server.in, forged),
            "refused: the packet is not from the peer, or it was altered");
  EXPECT_FALSE(pair.server.in.opened_any());
  EXPECT_EQ(opened(pair.server.in, frame), "right");
  EXPECT_TRUE(pair.server.in.opened_any());
}

TEST(Transport, FramesThatAreTooShortAreRefused) {
  auto pair = open_pair();
  for (std::size_t size = 0; size < Sealer::overhead; ++size) {
    EXPECT_EQ(opened(pair.server.in, Bytes(size)),
              "refused: the packet is too short for a sealed packet");
  }
  Bytes no_room(Sealer::overhead - 1);
  EXPECT_THROW(pair.client.out.seal({}, no_room), std::invalid_argument);
}

TEST(Transport, KeysMoveOnByCount) {
  auto pair = open_pair({.packets = 3});
  for (int i = 0; i < 30; ++i) {
    const auto text = std::to_string(i);
    ASSERT_EQ(opened(pair.server.in, sealed(pair.client.out, text)), text);
  }
  EXPECT_EQ(pair.client.out.generation(), 9U);
  EXPECT_EQ(pair.server.in.generation(), 9U);
  EXPECT_EQ(pair.server.out.generation(), 0U) << "each direction by itself";
}

TEST(Transport, KeysMoveOnByTimeWhenTheyWereUsed) {
  auto pair = open_pair({.after = 2min});
  pair.client.out.on_tick(pair_opened + 3min);
  EXPECT_EQ(pair.client.out.generation(), 0U) << "nothing was sealed with it";
  ASSERT_EQ(opened(pair.server.in, sealed(pair.client.out, "old")), "old");
  pair.client.out.on_tick(pair_opened + 5min - 1ns);
  EXPECT_EQ(pair.client.out.generation(), 0U);
  pair.client.out.on_tick(pair_opened + 5min);
  EXPECT_EQ(pair.client.out.generation(), 1U);
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "new")), "new");
}

TEST(Transport, APacketThatTheNextKeyOvertookIsOpenedUntilThatKeyIsErased) {
  auto pair = open_pair({.packets = 2});
  const Bytes early = sealed(pair.client.out, "early");
  const Bytes late = sealed(pair.client.out, "late");
  ASSERT_EQ(opened(pair.server.in, sealed(pair.client.out, "next key")), "next key");
  EXPECT_EQ(opened(pair.server.in, early), "early");
  EXPECT_EQ(opened(pair.server.in, early), "refused: the packet was delivered already");
  pair.server.in.on_tick(pair_opened);
  pair.server.in.on_tick(pair_opened + Opener::previous_kept - 1ns);
  EXPECT_EQ(opened(pair.server.in, early), "refused: the packet was delivered already")
      << "its window is there";
  pair.server.in.on_tick(pair_opened + Opener::previous_kept);
  EXPECT_EQ(opened(pair.server.in, late), "refused: the packet is too old");
}

TEST(Transport, GenerationsLostAsAWholeAreCaughtUpWithAndNoMore) {
  auto pair = open_pair({.packets = 1});
  Bytes frame;
  for (std::uint32_t i = 0; i <= Opener::most_lost_generations; ++i) {
    frame = sealed(pair.client.out, "after a gap");
  }
  EXPECT_EQ(opened(pair.server.in, frame), "after a gap");
  for (std::uint32_t i = 0; i <= Opener::most_lost_generations; ++i) {
    frame = sealed(pair.client.out, "too far");
  }
  EXPECT_EQ(opened(pair.server.in, frame),
            "refused: the packet is sealed under a key that the peer cannot use yet");
  EXPECT_EQ(pair.server.in.generation(), Opener::most_lost_generations);
}

TEST(Transport, AForgedGenerationMovesNoKey) {
  auto pair = open_pair({.packets = 1});
  Bytes forged = sealed(pair.client.out, "x");
  forged[3] = std::byte{5};  // the lowest byte of the generation
  EXPECT_EQ(opened(pair.server.in, forged),
            "refused: the packet is not from the peer, or it was altered");
  EXPECT_EQ(pair.server.in.generation(), 0U);
  EXPECT_EQ(opened(pair.server.in, sealed(pair.client.out, "y")), "y");
}

}  // namespace
}  // namespace gecos::crypto
