#include "gecos/media/testing/faulty.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>

#include "gecos/media/inproc/inproc.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

/// A client's packets arriving over a faulty line, by a fake clock.
struct Line {
  explicit Line(const Faults& faults)
      : medium(make_faulty(make_inproc(), faults, clock)),
        acceptor(medium->listen("RX90", false).value()),
        client(std::move(*medium->connect(acceptor->address()))),
        server(acceptor->accept()) {}

  std::vector<std::string> arrived() {
    std::vector<std::string> all;
    while (const auto packet = server.connection->receive()) {
      all.emplace_back(reinterpret_cast<const char*>(packet->data()), packet->size());
    }
    return all;
  }

  FakeClock clock;
  std::unique_ptr<Medium> medium;
  std::unique_ptr<Acceptor> acceptor;
  End client;
  End server;
};

std::vector<std::string> send_many(Line& line, int count) {
  std::vector<std::string> arrived;
  for (int i = 0; i < count; ++i) {
    EXPECT_TRUE(line.client.send(std::to_string(i)));
    for (auto& text : line.arrived()) arrived.push_back(std::move(text));
    line.clock.advance(1ms);
  }
  line.clock.advance(10s);
  for (auto& text : line.arrived()) arrived.push_back(std::move(text));
  return arrived;
}

TEST(Faulty, WithoutFaultsItIsTheMediumBelow) {
  Line line({});
  EXPECT_TRUE(line.medium->capabilities().reliable);
  EXPECT_TRUE(line.medium->capabilities().ordered);
  const auto arrived = send_many(line, 100);
  ASSERT_EQ(arrived.size(), 100u);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(arrived[i], std::to_string(i));
  EXPECT_EQ(line.client.connection->taken_by_peer(), 100u);
}

TEST(Faulty, LosesAboutAsManyAsItIsAskedTo) {
  Line line({.loss = 0.1});
  EXPECT_FALSE(line.medium->capabilities().reliable);
  const auto arrived = send_many(line, 5000);
  EXPECT_NEAR(static_cast<double>(arrived.size()), 4500, 100);
  EXPECT_FALSE(line.client.connection->taken_by_peer())
      << "nothing is known over a line that loses";
}

TEST(Faulty, RepeatsSome) {
  Line line({.duplication = 0.1});
  std::map<std::string, int> times;
  for (const auto& text : send_many(line, 5000)) ++times[text];
  EXPECT_EQ(times.size(), 5000u);
  const auto twice = std::ranges::count_if(times, [](const auto& t) { return t.second == 2; });
  EXPECT_NEAR(static_cast<double>(twice), 500, 100);
}

TEST(Faulty, FlipsOneBitOfSome) {
  Line line({.corruption = 0.5});
  int flipped = 0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(line.client.send("the same"));
    const auto arrived = line.arrived();
    ASSERT_EQ(arrived.size(), 1u);
    int bits = 0;
    for (std::size_t at = 0; at < arrived[0].size(); ++at) {
      bits += std::popcount(static_cast<unsigned char>(arrived[0][at] ^ "the same"[at]));
    }
    ASSERT_LE(bits, 1);
    flipped += bits;
  }
  EXPECT_NEAR(flipped, 500, 100);
}

TEST(Faulty, LetsLaterPacketsOvertakeWithoutLosingAny) {
  Line line({.reordering = 0.3});
  EXPECT_FALSE(line.medium->capabilities().ordered);
  EXPECT_TRUE(line.medium->capabilities().reliable);
  auto arrived = send_many(line, 1000);
  int overtaken = 0;
  for (std::size_t i = 1; i < arrived.size(); ++i) {
    overtaken += std::stoi(arrived[i]) < std::stoi(arrived[i - 1]);
  }
  EXPECT_GT(overtaken, 100);
  std::ranges::sort(arrived);
  EXPECT_EQ(std::unique(arrived.begin(), arrived.end()), arrived.end());
  EXPECT_EQ(arrived.size(), 1000u);
}

TEST(Faulty, DelaysLikeASatelliteAndWakesNobodyBefore) {
  Line line({.delay = 250ms});
  ASSERT_TRUE(line.client.send("move"));
  EXPECT_TRUE(line.arrived().empty());
  ASSERT_TRUE(line.server.connection->prepare_to_sleep()) << "nothing is due";
  line.server.connection->woke();
  line.clock.advance(249ms);
  EXPECT_TRUE(line.arrived().empty());
  line.clock.advance(1ms);
  EXPECT_FALSE(line.server.connection->prepare_to_sleep()) << "now it is";
  EXPECT_EQ(line.arrived(), std::vector<std::string>{"move"});
}

TEST(Faulty, ASleeperIsWokenForADelayedPacket) {
  const SystemClock clock;
  const auto medium = make_faulty(make_inproc(), {.delay = 20ms}, clock);
  const auto acceptor = medium->listen("RX90", false).value();
  End client(std::move(*medium->connect(acceptor->address())));
  End server(acceptor->accept());
  const TimePoint sent = clock.now();
  ASSERT_TRUE(client.send("move"));
  EXPECT_EQ(server.receive(), "move");
  EXPECT_GE(clock.now() - sent, 20ms);
}

TEST(Faulty, ACutLineIsSilentUntilItIsMended) {
  std::atomic<bool> cut{false};
  Line line({.cut = &cut});
  line.client.connection->beat();
  const std::uint64_t beats = line.server.connection->beats_seen();
  cut.store(true);
  ASSERT_TRUE(line.client.send("lost"));
  line.client.connection->beat();
  EXPECT_TRUE(line.arrived().empty());
  EXPECT_EQ(line.server.connection->beats_seen(), beats);
  EXPECT_EQ(line.server.connection->loss(), Loss::None);
  cut.store(false);
  ASSERT_TRUE(line.client.send("heard"));
  EXPECT_EQ(line.arrived(), std::vector<std::string>{"heard"});
  EXPECT_GT(line.server.connection->beats_seen(), beats);
}

TEST(Faulty, TheSameSeedGivesTheSameFaults) {
  const Faults faults{
      .seed = 7, .loss = 0.2, .duplication = 0.2, .corruption = 0.2, .reordering = 0.3};
  Line one(faults);
  Line two(faults);
  const auto first = send_many(one, 500);
  EXPECT_EQ(first, send_many(two, 500));
  Faults others = faults;
  others.seed = 8;
  Line three(others);
  EXPECT_NE(first, send_many(three, 500));
}

}  // namespace
}  // namespace gecos::media
