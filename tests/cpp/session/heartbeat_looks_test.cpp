#include "gecos/session/server/heartbeat_looks.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint start{100s};

/// A client that sends heartbeats, each up to `late` later than it should.
struct Client {
  TimePoint next;
  TimePoint sent{};  ///< when it sent the last heartbeat
  std::uint64_t heartbeats = 0;
  HeartbeatLooks looks{};
  std::uint64_t found = 0;

  void run_until(TimePoint now, Duration late, std::mt19937& random) {
    while (next <= now) {
      ++heartbeats;
      sent = next;
      next += heartbeat_period + late * std::uniform_int_distribution(0, 100)(random) / 100;
    }
  }
};

struct Seen {
  double ticks_a_second = 0;
  Duration oldest{};       ///< the greatest age that a heartbeat had when a look found it
  Duration longest_gap{};  ///< the longest time between two heartbeats of the server
};

/// Lets a server look at its clients for 20 s, whose phases are random. The first two seconds do
/// not count. A tick begins up to `late` later than it is due; so does a heartbeat.
Seen simulate(std::size_t clients, Duration late, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Client> all;
  for (std::size_t i = 0; i < clients; ++i) {
    all.push_back({start + std::uniform_int_distribution(0, 99)(random) * 1ms});
  }
  OwnHeartbeats own;
  Seen seen;
  std::size_t ticks = 0;
  TimePoint own_sent = start;
  const TimePoint counts_from = start + 2s;
  for (TimePoint now = start; now < start + 22s;) {
    const bool counts = now >= counts_from;
    if (counts) ++ticks;
    if (own.due(now, heartbeat_period)) {
      if (counts) seen.longest_gap = std::max(seen.longest_gap, now - own_sent);
      own_sent = now;
    }
    TimePoint next_look = TimePoint::max();
    for (Client& client : all) {
      client.run_until(now, late, random);
      if (client.heartbeats != client.found && counts) {
        seen.oldest = std::max(seen.oldest, now - client.sent);
      }
      client.found = client.heartbeats;
      next_look = std::min(next_look, client.looks.look(client.heartbeats, now));
    }
    now = std::max(own.next_tick(next_look), now + Maintenance::tick) +
          late * std::uniform_int_distribution(0, 100)(random) / 100;
  }
  seen.ticks_a_second = static_cast<double>(ticks) / 20;
  return seen;
}

TEST(HeartbeatLooksTest, OneRegularClientCostsFewTicks) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    EXPECT_LE(simulate(1, 1ms, seed).ticks_a_second, 17) << "seed " << seed;
    EXPECT_LE(simulate(1, 10ms, seed).ticks_a_second, 22) << "seed " << seed;
  }
}

TEST(HeartbeatLooksTest, WithoutClientsATickIsAHeartbeat) {
  const Seen seen = simulate(0, 0ms, 0);
  EXPECT_DOUBLE_EQ(seen.ticks_a_second, 10);
  EXPECT_EQ(seen.longest_gap, heartbeat_period);
}

TEST(HeartbeatLooksTest, EachHeartbeatIsFoundSoonHoweverManyClientsThereAre) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    for (const std::size_t clients : {1, 2, 3, 10}) {
      for (const Duration late : {Duration(0ms), Duration(2ms), Duration(10ms)}) {
        const Seen seen = simulate(clients, late, seed);
        const auto what = ::testing::Message()
                          << clients << " clients, " << late / 1ms << " ms, seed " << seed;
        // A heartbeat that comes later than the last one shifts against the looks.
        EXPECT_LE(seen.oldest, tick_window + 2 * late + 2ms) << what;
        EXPECT_LE(seen.ticks_a_second, 41) << what;
        EXPECT_LE(seen.longest_gap, heartbeat_period + tick_window + late) << what;
      }
    }
  }
}

/// A client may send each heartbeat up to `tick_window` early.
TEST(HeartbeatLooksTest, EarlyHeartbeatsAreFoundWithinTwoWindows) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    HeartbeatLooks looks;
    TimePoint sent = start, next_sent = start;
    std::uint64_t heartbeats = 0, found = 0;
    for (TimePoint now = start; now < start + 20s; now = looks.look(heartbeats, now)) {
      while (next_sent <= now) {
        sent = next_sent;
        ++heartbeats;
        next_sent +=
            heartbeat_period - tick_window * std::uniform_int_distribution(0, 100)(random) / 100;
      }
      if (heartbeats != found && now > start + 2s) {
        EXPECT_LE(now - sent, 2 * tick_window) << "seed " << seed;
      }
      found = heartbeats;
    }
  }
}

TEST(HeartbeatLooksTest, AClientThatFallsSilentIsLookedAtOften) {
  HeartbeatLooks looks;
  looks.look(1, start);
  TimePoint now = start + 100ms;
  for (int i = 0; i < 20; ++i) {
    const TimePoint next = looks.look(1, now);
    EXPECT_EQ(next, now + tick_window);
    now = next;
  }
}

}  // namespace
}  // namespace gecos::session
