#include "gecos/media/waiting.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/time.h>

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/event_fd.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

/// A core and a clock that a test moves: each reading and each yield takes its time.
class FakeCore final : public Clock, public Core {
 public:
  TimePoint now() const override {
    at += reading;
    ++readings;
    return at;
  }
  Duration unix_time() const override { return {}; }
  std::int32_t number() const override { return core; }
  void yield() const override {
    ++yields;
    at += yield_takes;
  }

  std::int32_t core = 0;
  Duration reading{};
  Duration yield_takes = 500ns;
  mutable TimePoint at{1h};
  mutable int readings = 0;
  mutable int yields = 0;
};

class Waiting : public ::testing::Test {
 protected:
  /// Looks until the policy gives up; each look takes `look`. How many there were.
  int looks_in_vain(Peers peers, Duration look = 10ns) {
    int looks = 0;
    spin_.begin();
    while (spin_.again([&] { return peers; })) {
      ++looks;
      core_.at += look;
    }
    return looks;
  }
  /// One wait that ends with a sleep: the peer rings after `wait`, this thread wakes `cost` later.
  void sleeps(Duration wait, Duration cost, Peers peers = Peers::Elsewhere) {
    const TimePoint began = core_.at;
    looks_in_vain(peers);
    const TimePoint rang_at = std::max(began + wait, core_.at);
    core_.at = rang_at + cost;
    spin_.woke(rang_at, Woken::ByAnswer);
  }
  void lose_a_slice() {
    core_.yield_takes = 4ms;
    spin_.begin();
    while (spin_.again([] { return Peers::Here; })) {
    }
    core_.yield_takes = 500ns;
  }

  FakeCore core_;
  SpinPolicy spin_{core_, {}, core_};
};

TEST_F(Waiting, ForAPeerElsewhereItLooksForItsBudgetWithoutYields) {
  const TimePoint began = core_.at;
  looks_in_vain(Peers::Elsewhere);
  EXPECT_EQ(core_.yields, 0);
  EXPECT_GE(core_.at - began, 50us);
  EXPECT_LE(core_.at - began, 50us + 2 * 256 * 10ns);
  EXPECT_FALSE(spin_.again([] { return Peers::Elsewhere; })) << "a wait that is over looks again";
}

TEST_F(Waiting, AQuickAnswerFromElsewhereNeedsNoReadingOfTheClock) {
  for (int wait = 0; wait < 100; ++wait) {
    spin_.begin();
    for (int look = 0; look < 200; ++look) {
      ASSERT_TRUE(spin_.again([] { return Peers::Elsewhere; }));
    }
  }
  EXPECT_EQ(core_.readings, 0);
}

TEST_F(Waiting, APeerHereGetsTheCoreAfterEveryLook) {
  const int looks = looks_in_vain(Peers::Here);
  EXPECT_EQ(core_.yields, looks);
  EXPECT_NEAR(looks, 50us / (500ns + 10ns), 5);
}

TEST_F(Waiting, APeerThatMovesHereGetsTheCoreWithinSomeLooks) {
  Peers peers = Peers::Elsewhere;
  spin_.begin();
  ASSERT_TRUE(spin_.again([&] { return peers; }));
  peers = Peers::Here;
  for (int look = 0; look < 256; ++look) ASSERT_TRUE(spin_.again([&] { return peers; }));
  EXPECT_EQ(core_.yields, 0);
  ASSERT_TRUE(spin_.again([&] { return peers; }));
  EXPECT_EQ(core_.yields, 1);
}

TEST_F(Waiting, WithPeersOnBothSidesYieldsAreFarApart) {
  for (int wait = 0; wait < 2000; ++wait) {  // of a microsecond each
    spin_.begin();
    ASSERT_TRUE(spin_.again([] { return Peers::Both; }));
    core_.at += 1us;
  }
  EXPECT_GE(core_.yields, 4);
  EXPECT_LE(core_.yields, 6);
}

TEST_F(Waiting, ALostSliceStopsYieldsForAWhileThatDoubles) {
  Duration expected = 20ms;
  for (int time = 0; time < 8; ++time) {
    lose_a_slice();
    EXPECT_EQ(spin_.crowded_until() - core_.at, expected);
    EXPECT_EQ(looks_in_vain(Peers::Here), 0) << "it sleeps at once";
    EXPECT_TRUE(spin_.gave_way());
    expected = std::min<Duration>(2 * expected, 1s);
    core_.at = spin_.crowded_until();
  }
}

TEST_F(Waiting, ASpinInWhichTheCoreStayedOursForgetsLostSlices) {
  lose_a_slice();
  core_.at = spin_.crowded_until();
  lose_a_slice();
  core_.at = spin_.crowded_until();
  EXPECT_GT(looks_in_vain(Peers::Here), 10);
  lose_a_slice();
  EXPECT_EQ(spin_.crowded_until() - core_.at, 20ms);
}

TEST_F(Waiting, ALostSliceSaysNothingOfAnotherCore) {
  lose_a_slice();
  core_.core = 1;
  EXPECT_GT(looks_in_vain(Peers::Here), 10);
}

TEST_F(Waiting, OnACrowdedCoreItLooksForPeersElsewhere) {
  lose_a_slice();
  core_.yields = 0;
  EXPECT_GT(looks_in_vain(Peers::Elsewhere), 1000);
  EXPECT_GT(looks_in_vain(Peers::Both), 1000);
  EXPECT_EQ(core_.yields, 0);
}

TEST_F(Waiting, OnACrowdedCoreLooksForAPeerAnywhereAreGivenUpAfterEightInVain) {
  lose_a_slice();
  for (int wait = 0; wait < 8; ++wait) EXPECT_GT(looks_in_vain(Peers::Unknown), 1000);
  EXPECT_EQ(looks_in_vain(Peers::Unknown), 0);
}

TEST_F(Waiting, OnACrowdedCoreALookThatFindsSomethingIsAReasonForMore) {
  lose_a_slice();
  for (int wait = 0; wait < 30; ++wait) {
    if (wait % 3 != 0) {
      EXPECT_GT(looks_in_vain(Peers::Unknown), 0);
      continue;
    }
    spin_.begin();
    EXPECT_TRUE(spin_.again([] { return Peers::Unknown; }));  // and then it came
  }
}

TEST_F(Waiting, AWaitOfOneYieldReadsTheClockOnce) {
  for (int wait = 0; wait < 100; ++wait) {
    spin_.begin();
    EXPECT_TRUE(spin_.again([] { return Peers::Here; }));
  }
  EXPECT_LE(core_.readings, 101 + 64) << "the very first is doubtful";
}

TEST_F(Waiting, ALongTimeBetweenTwoWaitsIsNoLostSlice) {
  for (int wait = 0; wait < 8; ++wait) {
    spin_.begin();
    EXPECT_TRUE(spin_.again([] { return Peers::Here; }));
    core_.at += 5ms;  // a handler, say
  }
  EXPECT_EQ(spin_.crowded_until(), TimePoint{});
}

TEST_F(Waiting, ALostSliceInWaitsOfOneYieldIsNoticedByOneOfTheNext) {
  int waits = 0;
  for (; spin_.crowded_until() == TimePoint{} && waits < 40; ++waits) {
    core_.yield_takes = waits % 4 == 0 ? 4ms : 500ns;  // every fourth goes to a stranger
    spin_.begin();
    spin_.again([] { return Peers::Here; });
  }
  EXPECT_LE(waits, 6);
}

// The budget

TEST_F(Waiting, ItLooksForAsLongAsAWakeUpCostsOnAverage) {
  EXPECT_EQ(spin_.budget(), 50us);
  sleeps(100us, 850us);
  EXPECT_EQ(spin_.budget(), 150us) << "one of eight";
  for (int wait = 0; wait < 60; ++wait) sleeps(1ms, wait % 2 == 0 ? 100us : 3900us);
  EXPECT_NEAR(static_cast<double>(spin_.budget() / 1us), 2000, 400);
}

TEST_F(Waiting, TheBudgetIsBounded) {
  for (int wait = 0; wait < 100; ++wait) sleeps(6ms, 3s);
  EXPECT_LE(spin_.budget(), 5ms);
  EXPECT_GE(spin_.budget(), 4900us);
  for (int wait = 0; wait < 100; ++wait) sleeps(6ms, 1us);
  EXPECT_GE(spin_.budget(), 50us);
  EXPECT_LT(spin_.budget(), 60us);
}

TEST_F(Waiting, ARingOfAnotherWaitOrOfTheFutureTeachesNothing) {
  looks_in_vain(Peers::Elsewhere);
  spin_.woke(core_.at - 1s, Woken::ByAnswer);
  looks_in_vain(Peers::Elsewhere);
  spin_.woke(core_.at + 1s, Woken::ByAnswer);
  looks_in_vain(Peers::Elsewhere);
  spin_.woke(TimePoint{}, Woken::ByAnswer);
  EXPECT_EQ(spin_.budget(), 50us);
}

TEST_F(Waiting, LongWaitsHalveTheBudgetAndAShortOneRestoresIt) {
  for (int wait = 0; wait < 20; ++wait) sleeps(100us, 4ms);
  for (int wait = 0; wait < 12; ++wait) sleeps(11ms, 4ms);
  EXPECT_EQ(spin_.budget(), 2us);
  sleeps(30us, 20us);
  EXPECT_EQ(spin_.budget(), 50us);
}

TEST_F(Waiting, AReportInAdvanceTeachesNothing) {
  for (int wait = 0; wait < 20; ++wait) {
    looks_in_vain(Peers::Elsewhere);
    core_.at += 60us;
    spin_.woke(core_.at - 40us, Woken::Early);
    sleeps(11ms, 40us);
  }
  EXPECT_EQ(spin_.budget(), 2us) << "every second wait is short, and each answer comes late";
}

TEST_F(Waiting, ASliceLostWhileItLooksCountsAsAShortTime) {
  for (int wait = 0; wait < 40; ++wait) sleeps(6ms, 5ms);
  int slices = 0;
  spin_.begin();
  for (int look = 1; spin_.again([] { return Peers::Elsewhere; }); ++look) {
    const bool lost = look % 1000 == 0;
    core_.at += lost ? 4ms : 100ns;
    slices += lost ? 1 : 0;
  }
  EXPECT_GT(slices, 5) << "with 5 ms of its own it looks through some slices of a stranger";
}

TEST_F(Waiting, ACostThatFellIsNoticedThoughNoWaitSleeps) {
  for (int wait = 0; wait < 40; ++wait) sleeps(6ms, 5ms);
  int waits = 0;
  for (; spin_.budget() > 500us && waits < 10'000; ++waits) {
    const TimePoint began = core_.at;
    const TimePoint answer = began + 1ms;
    spin_.begin();
    while (core_.at < answer && spin_.again([] { return Peers::Elsewhere; })) core_.at += 100ns;
    if (core_.at >= answer) continue;
    core_.at = answer + 60us;
    spin_.woke(answer, Woken::ByAnswer);
  }
  EXPECT_LE(waits, 16 * 25);
}

TEST_F(Waiting, ABudgetOfZeroNeverLooks) {
  SpinPolicy never(core_, {.longest = 0ns}, core_);
  never.begin();
  EXPECT_FALSE(never.again([] { return Peers::Elsewhere; }));
  never.woke(core_.at, Woken::ByAnswer);
  EXPECT_EQ(never.budget(), 0ns);
}

// Whole conditions: what a wait takes beside the best of looking for ever and sleeping at once.

struct Condition {
  const char* name;
  Duration answer;   ///< what an answer takes while its server has a core
  Duration slice;    ///< how long strangers keep a core that they got
  int lost_every;    ///< one in so many answers waits for a core that a stranger has
  Duration wake_up;  ///< what a wake-up costs at most; on average the half
};

class InCondition : public ::testing::TestWithParam<Condition> {};

/// Calls in a row to a server elsewhere; what one takes on average when it waits by `policy`.
template <class Wait>
Duration mean_of(const Condition& condition, Wait wait) {
  FakeCore core;
  constexpr int calls = 2000;
  const TimePoint began = core.at;
  unsigned random = 1;
  for (int call = 0; call < calls; ++call) {
    random = random * 1664525U + 1013904223U;
    const bool lost = condition.lost_every != 0 && call % condition.lost_every == 0;
    const Duration part = condition.slice * (random >> 16) / 65536;
    wait(core, core.at + condition.answer + (lost ? part : Duration{}),
         condition.wake_up / 4 + condition.wake_up * (random >> 20) / 8192);
  }
  return (core.at - began) / calls;
}

TEST_P(InCondition, AWaitTakesAtMostTwiceTheBestChoice) {
  const Duration looking = mean_of(GetParam(), [](FakeCore& core, TimePoint answer, Duration) {
    core.at = std::max(core.at, answer);
  });
  const Duration sleeping =
      mean_of(GetParam(), [](FakeCore& core, TimePoint answer, Duration wake_up) {
        core.at = std::max(core.at, answer) + wake_up;
      });
  std::optional<SpinPolicy> spin;
  const Duration ours = mean_of(GetParam(), [&](FakeCore& core, TimePoint answer, Duration cost) {
    if (!spin) spin.emplace(core, SpinOptions{}, core);
    spin->begin();
    while (core.at < answer && spin->again([] { return Peers::Elsewhere; })) core.at += 200ns;
    if (core.at >= answer) return;
    core.at = answer + cost;
    spin->woke(answer, Woken::ByAnswer);
  });
  EXPECT_LE(ours, 2 * std::min(looking, sleeping) + 100ns)
      << "looking " << looking.count() << " ns, sleeping " << sleeping.count() << " ns";
}

INSTANTIATE_TEST_SUITE_P(
    Machines, InCondition,
    ::testing::Values(Condition{"quiet", 1us, 0ns, 0, 40us},
                      Condition{"quiet_slow_handler", 300us, 0ns, 0, 40us},
                      Condition{"wake_up_at_once_beside_loops", 1us, 3ms, 1000, 60us},
                      Condition{"wake_up_costs_a_slice", 1us, 4ms, 1000, 4ms},
                      Condition{"short_slices", 1us, 100us, 50, 200us},
                      Condition{"long_slices", 1us, 100ms, 1000, 20ms},
                      Condition{"slow_handler_and_costly_wake_up", 2ms, 4ms, 10, 4ms}),
    [](const auto& one) { return std::string(one.param.name); });

TEST(RunningCore, IsTheOneThatThisThreadWasMovedTo) {
  cpu_set_t before;
  ASSERT_EQ(::sched_getaffinity(0, sizeof before, &before), 0);
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(static_cast<std::size_t>(core), &before)) continue;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(core), &one);
    ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
    EXPECT_EQ(running_core(), core);
    EXPECT_EQ(place_of({.core = core}), Peers::Here);
    EXPECT_EQ(place_of({.core = core + 1}), Peers::Elsewhere);
    EXPECT_EQ(place_of({}), Peers::Unknown);
  }
  ::sched_setaffinity(0, sizeof before, &before);
}

TEST(SleepOn, AReadableDescriptorWakes) {
  EventFd quiet;
  EventFd rung;
  rung.notify();
  const std::array descriptors{quiet.descriptor(), -1, rung.descriptor()};
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Ready);
}

TEST(SleepOn, ReturnsAtItsDeadline) {
  EventFd quiet;
  const std::array descriptors{quiet.descriptor()};
  const TimePoint deadline = std::chrono::steady_clock::now() + 5ms;
  EXPECT_EQ(sleep_on(descriptors, deadline), Wake::TimedOut);
  EXPECT_GE(std::chrono::steady_clock::now(), deadline);
  EXPECT_EQ(sleep_on(descriptors, TimePoint{}), Wake::TimedOut) << "a deadline in the past";
}

TEST(SleepOn, WatchesMoreDescriptorsThanUsual) {
  std::vector<EventFd> events(40);
  std::vector<int> descriptors;
  for (const EventFd& event : events) descriptors.push_back(event.descriptor());
  EXPECT_EQ(sleep_on(descriptors, TimePoint{}), Wake::TimedOut);
  notify_event_fd(descriptors.back());
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Ready);
}

TEST(SleepOn, ASignalIsReported) {
  // The timer repeats, so that one signal before the sleep began costs only the next one.
  struct sigaction act {};
  act.sa_handler = [](int) {};
  struct sigaction before {};
  ASSERT_EQ(::sigaction(SIGALRM, &act, &before), 0);
  const itimerval every_5_ms{{0, 5000}, {0, 5000}};
  ASSERT_EQ(::setitimer(ITIMER_REAL, &every_5_ms, nullptr), 0);
  EventFd quiet;
  const std::array descriptors{quiet.descriptor()};
  EXPECT_EQ(sleep_on(descriptors, TimePoint::max()), Wake::Interrupted);
  const itimerval off{};
  ::setitimer(ITIMER_REAL, &off, nullptr);
  ::sigaction(SIGALRM, &before, nullptr);
}

TEST(EventFd, QuietNeverBlocksWhateverThePeerDidToIt) {
  EventFd event;
  ASSERT_EQ(::fcntl(event.descriptor(), F_SETFL, 0), 0);  // what a hostile peer may do
  EXPECT_FALSE(event.drain());
  event.notify();
  event.notify();
  EXPECT_TRUE(event.drain());
  EXPECT_FALSE(event.drain());
}

}  // namespace
}  // namespace gecos::media
