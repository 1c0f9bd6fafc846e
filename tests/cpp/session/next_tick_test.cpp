// Do the periodic tasks of a process share their wake-ups? Simulated processes, with the real rules
// for heartbeats and looks.
#include "gecos/session/process/next_tick.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <random>

#include "gecos/session/client/client_heartbeats.hpp"
#include "gecos/session/server/heartbeat_looks.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint began{100s};
constexpr TimePoint counts_from = began + 10s;
constexpr TimePoint ends = began + 20s;

/// A session of a client.
struct Session {
  ClientHeartbeats heartbeats{heartbeat_period, ClientHeartbeats::Sent::InMemory, began};
  Duration other_work = Duration::max() / 2;  ///< such as to poll for the answers of open calls
  std::uint64_t sent = 0;
  TimePoint last{};
  Duration shortest = Duration::max(), longest{};

  NextTick on_tick(TimePoint now) {
    if (heartbeats.due(now)) {
      if (sent++ > 0) {
        shortest = std::min(shortest, now - last);
        longest = std::max(longest, now - last);
      }
      last = now;
    }
    return heartbeats.next_tick(now + other_work);
  }
};

/// A server that looks for the heartbeats of clients, and sends heartbeats of its own.
struct Looking {
  std::vector<const Session*> clients;
  std::vector<HeartbeatLooks> looks{clients.size()};
  OwnHeartbeats own{};

  NextTick on_tick(TimePoint now) {
    own.due(now, heartbeat_period);
    TimePoint next = TimePoint::max();
    for (std::size_t i = 0; i < clients.size(); ++i) {
      next = std::min(next, looks[i].look(clients[i]->sent, now));
    }
    return own.next_tick(next);
  }
};

/// A process: its targets, in the order of their creation, and its maintenance thread.
class Process {
 public:
  struct Target : TickTimes {
    std::function<NextTick(TimePoint)> on_tick;
  };
  template <class T>
  void add(T& target, TimePoint first_tick) {
    targets_.emplace_back();
    targets_.back().next = first_tick;
    targets_.back().on_tick = [&target](TimePoint now) { return target.on_tick(now); };
    wakes_at = wake_at(targets_);
  }
  void run(Duration late) {
    const TimePoint now = wakes_at;
    if (now >= counts_from) ++wake_ups_;
    tick_due(targets_, now, [&](std::size_t at) { return targets_[at].on_tick(now); });
    const auto rest = std::max(wake_at(targets_) - now, Duration(10ms));
    wakes_at = now + std::chrono::ceil<std::chrono::milliseconds>(rest) + late;
  }
  /// Per second.
  double wake_ups() const {
    return wake_ups_ / std::chrono::duration<double>(ends - counts_from).count();
  }

  TimePoint wakes_at{};

 private:
  std::vector<Target> targets_;
  double wake_ups_ = 0;
};

/// Processes whose sessions begin at random times, and whose threads wake up to 1 ms late.
struct Host {
  explicit Host(unsigned seed) : random(seed) {}
  TimePoint some_time() { return began + std::uniform_int_distribution(0, 300)(random) * 1ms; }
  void run(const std::vector<Process*>& processes) {
    for (;;) {
      Process& next = **std::ranges::min_element(processes, {}, &Process::wakes_at);
      if (next.wakes_at >= ends) return;
      next.run(std::uniform_int_distribution(100, 1000)(random) * 1us);
    }
  }
  std::mt19937 random;
};

void expect_regular(const Session& session) {
  EXPECT_GE(session.shortest, heartbeat_period - 20ms);
  EXPECT_LE(session.longest, heartbeat_period + 10ms + 3ms);
}

/// Calls `test` with hosts whose sessions begin at different times.
template <class Test>
void on_hosts(Test test) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    test(Host(seed));
  }
}

TEST(NextTick, AServerWithoutClientsWakesOnceForItselfAndItsSessionWithTheBroker) {
  on_hosts([](Host host) {
    Looking server{{}};
    Session broker;
    Process process;
    process.add(server, began);
    process.add(broker, host.some_time());
    host.run({&process});
    EXPECT_LE(process.wake_ups(), 10.1);
    expect_regular(broker);
  });
}

TEST(NextTick, AServerWithAClientWakesForItsLooksAlone) {
  on_hosts([](Host host) {
    Session client, broker;
    Looking server{{&client}};
    Process process, other;
    process.add(server, began);
    process.add(broker, host.some_time());
    other.add(client, host.some_time());
    host.run({&process, &other});
    EXPECT_LE(process.wake_ups(), 17);
    EXPECT_LE(other.wake_ups(), 10.1);
    expect_regular(broker);
  });
}

TEST(NextTick, AllSessionsOfAClientShareAWakeUp) {
  on_hosts([](Host host) {
    std::vector<Session> sessions(20);
    Process process;
    for (Session& session : sessions) process.add(session, host.some_time());
    host.run({&process});
    EXPECT_LE(process.wake_ups(), 10.1);
    for (const Session& session : sessions) expect_regular(session);
  });
}

TEST(NextTick, AProcessThatUsesItsOwnObjectLooksForItsOwnHeartbeats) {
  on_hosts([](Host host) {
    Session client, broker;
    Looking server{{&client}};
    Process process;
    process.add(server, began);
    process.add(broker, host.some_time());
    process.add(client, host.some_time());
    host.run({&process});
    EXPECT_LE(process.wake_ups(), 25);
    expect_regular(client);
  });
}

TEST(NextTick, TwoServersThatUseEachOtherWakeABoundedNumberOfTimes) {
  on_hosts([](Host host) {
    Session of_one, of_other;
    Looking one{{&of_other}}, other{{&of_one}};
    Process first, second;
    first.add(one, began);
    first.add(of_one, host.some_time());
    second.add(other, host.some_time());
    second.add(of_other, host.some_time());
    host.run({&first, &second});
    EXPECT_LE(first.wake_ups(), 29);
    EXPECT_LE(second.wake_ups(), 29);
    expect_regular(of_one);
  });
}

TEST(NextTick, ASessionWithAnOpenCallTicksForItAndSendsItsHeartbeatsInTime) {
  on_hosts([](Host host) {
    Session broker, busy;
    busy.other_work = 50ms;
    Process process;
    process.add(broker, host.some_time());
    process.add(busy, host.some_time());
    host.run({&process});
    EXPECT_LE(process.wake_ups(), 30.1) << "no more than without shifts";
    expect_regular(busy);
    expect_regular(broker);
  });
}

TEST(NextTick, ASessionApproachesARareTaskOnlyForAWhile) {
  on_hosts([](Host host) {
    struct Rare {
      NextTick on_tick(TimePoint now) { return now + 730ms; }
    };
    Rare rare;
    Session session;
    Process process;
    process.add(rare, host.some_time());
    process.add(session, host.some_time());
    host.run({&process});
    EXPECT_LE(process.wake_ups(), 12.5);
    expect_regular(session);
  });
}

TEST(NextTick, TasksThatCannotShiftKeepTheirTimes) {
  struct Fixed {
    NextTick on_tick(TimePoint now) { return now + 100ms; }
  };
  Fixed one, other;
  Process process;
  process.add(one, began);
  process.add(other, began + 40ms);
  Host(0).run({&process});
  EXPECT_GE(process.wake_ups(), 19);
}

TEST(NextTick, ASessionWithoutOtherTasksKeepsItsPeriod) {
  Session session;
  Process process;
  process.add(session, began);
  Host(0).run({&process});
  EXPECT_GE(session.shortest, heartbeat_period);
}

TEST(NextTick, HeartbeatsThatArePacketsAreSentAtTheSameTimesByAllSessions) {
  for (const Duration opened : {0ms, 1ms, 60ms, 99ms, 100ms}) {
    ClientHeartbeats heartbeats(heartbeat_period, ClientHeartbeats::Sent::AsPackets, began);
    EXPECT_TRUE(heartbeats.due(began + opened)) << "a session says at once that it lives";
    const Duration second = opened < 100ms ? 100ms : 200ms;
    EXPECT_FALSE(heartbeats.due(began + second - 1ns));
    EXPECT_TRUE(heartbeats.due(began + second + 7ms)) << "a tick may be late";
    EXPECT_EQ(heartbeats.next(), began + second + 100ms);
    EXPECT_EQ(heartbeats.next_tick(TimePoint::max()).shift, Duration{});
  }
}

TEST(NextTick, TheNewestTargetTicksFirst) {
  std::vector<TickTimes> targets(3);
  std::vector<std::size_t> order;
  tick_due(targets, began, [&](std::size_t at) {
    order.push_back(at);
    return TimePoint::max();
  });
  EXPECT_EQ(order, (std::vector<std::size_t>{2, 1, 0}));
}

}  // namespace
}  // namespace gecos::session
