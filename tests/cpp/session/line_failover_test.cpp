// A proxy whose interface has on_degraded="failover", and a medium that becomes slow while the
// program runs.
#include <future>

#include "../settles.hpp"
#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "written_lab_file.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::LineState;
using gecos::LineWatch;
using gecos::media::Kind;

constexpr gecos::Duration bound = 250ms;  ///< far above any delay of a busy machine

/// The delays of the media that the client uses, in ns.
struct Delays {
  std::atomic<gecos::Duration::rep> shm{0};
  std::atomic<gecos::Duration::rep> lcm{0};
};
Delays delays;

gecos::Lab delayed_lab(const std::string& lab_file = "") {
  static const gecos::SystemClock clock;
  gecos::LabOptions options = probe::patient();
  options.lab_file = lab_file;
  return gecos::session::LabAccess::with_media(
      std::move(options), [](std::unique_ptr<gecos::media::Medium> inner) {
        const std::string_view medium = inner->capabilities().name;
        if (medium != "shm" && medium != "lcm") return inner;
        const auto& delay = medium == "shm" ? delays.shm : delays.lcm;
        return gecos::media::make_faulty(std::move(inner), {.more_delay = &delay}, clock);
      });
}

class Mobile : public probe::Probe {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription demanding = probe::description();
      demanding.quality = {.line = gecos::qos::Class::SoftRealtime,
                           .latency = bound,
                           .on_degraded = gecos::qos::OnDegraded::Failover};
      return demanding;
    }();
    return described;
  }
  Mobile() = default;
  explicit Mobile(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(std::move(session)) {}
};

/// A Mobile that loses no sample of its level on the way.
class ReliableMobile : public Mobile {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const std::vector<gecos::StreamDescription> streams = [] {
      const auto known = Mobile::gecos_description().streams;
      std::vector<gecos::StreamDescription> all(known.begin(), known.end());
      for (auto& each : all) each.quality.reliability = gecos::qos::Reliability::Reliable;
      return all;
    }();
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription demanding = Mobile::gecos_description();
      demanding.streams = streams;
      return demanding;
    }();
    return described;
  }
  ReliableMobile() = default;
  explicit ReliableMobile(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(session), Mobile(session) {}
};

/// A Mobile that demands HARD_REALTIME.
class HardMobile : public Mobile {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription demanding = Mobile::gecos_description();
      demanding.quality.line = gecos::qos::Class::HardRealtime;
      return demanding;
    }();
    return described;
  }
  HardMobile() = default;
  explicit HardMobile(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(session), Mobile(session) {}
};

/// A server that offers shm and lcm. Proxies begin on shm, which is the better medium.
class LineFailover : public probe::Bench {
 protected:
  void SetUp() override {
    delays.shm = 0;
    delays.lcm = 0;
    Bench::SetUp();
    gecos::ObjectOptions options;
    options.media = {Kind::Shm, Kind::Lcm};
    const auto added = server_->add("PROBE", servant_, std::move(options));
    ASSERT_TRUE(added) << added.error().text;
  }
  Mobile create(std::optional<Kind> medium = {}) {
    auto created = far_.create<Mobile>("PROBE", {.medium = medium, .patience = 20s});
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Mobile();
  }
  static void slow_down(std::atomic<gecos::Duration::rep>& delay) {
    delay = gecos::Duration(600ms).count();
  }
  /// Waits for the change with this number.
  static LineState await(LineWatch& watch, std::uint64_t number) {
    for (;;) {
      const auto state = watch.next(60s);
      if (!state) ADD_FAILURE() << "change " << number << " did not come";
      if (!state || state->changes >= number) return state.value_or(LineState{});
    }
  }
  gecos::Lab far_ = delayed_lab();
};

std::string_view medium_of(const probe::Probe& robot) {
  return robot.session()->capabilities().name;
}

/// Whether the only session with the object is one over lcm.
bool only_over_lcm(const probe::Probe& robot) {
  const auto stats = gecos::stats(robot).get();
  return stats && stats->sessions.size() == 1 && stats->sessions.front().medium == "lcm";
}

TEST_F(LineFailover, CallsAndSamplesGoOnOverTheNextBestMediumAndOneEventSaysSo) {
  const auto robot = create();
  ASSERT_EQ(medium_of(robot), "shm");
  LineWatch watch(robot);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(1);
  const auto before = level->next(60s);
  ASSERT_TRUE(before);
  slow_down(delays.shm);
  const LineState moved = await(watch, 2);
  EXPECT_EQ(moved.changes, 2u) << "it was degraded, and it moved";
  EXPECT_EQ(moved.medium, "lcm");
  EXPECT_EQ(moved.moved_from, "shm");
  EXPECT_FALSE(moved.degraded);
  EXPECT_NE(moved.why.find("PROBE has moved from shm to lcm: PROBE over shm: the round trip took "),
            std::string::npos)
      << moved.why;
  EXPECT_NE(moved.why.find("for one second it has exceeded latency=250ms"), std::string::npos)
      << moved.why;
  EXPECT_EQ(medium_of(robot), "lcm");
  EXPECT_EQ(robot.read().get().value(), 7);
  servant_.publish(2);
  const auto after = level->next(60s);
  ASSERT_TRUE(after) << after.error();
  EXPECT_EQ(after->value, 2);
  EXPECT_EQ(after->sequence, before->sequence + 1);
  EXPECT_EQ(after->lost, 0u);
  EXPECT_EQ(level->counts().received, 2u);
  EXPECT_EQ(gecos::line_state(robot).changes, 2u);
}

TEST_F(LineFailover, AReaderThatWaitsGetsTheNextSampleOverTheOtherMedium) {
  const auto robot = create();
  LineWatch watch(robot);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  auto read = std::async(std::launch::async, [&] { return level->next(60s); });
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  EXPECT_TRUE(settles([&] { return only_over_lcm(robot); })) << "the reader has left shm";
  servant_.publish(5);
  const auto sample = read.get();
  ASSERT_TRUE(sample) << sample.error();
  EXPECT_EQ(sample->value, 5);
  EXPECT_FALSE(level->lost());
  const auto newest = level->latest();
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->value, 5);
}

TEST_F(LineFailover, SamplesThatWerePublishedMeanwhileAreReadOrCounted) {
  const auto robot = create();
  LineWatch watch(robot);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  std::int32_t published = 0;
  std::uint64_t read = 0;
  std::uint64_t lost = 0;
  const auto read_one = [&] {
    const auto sample = level->next(60s);
    ASSERT_TRUE(sample) << sample.error();
    ++read;
    lost += sample->lost;
    EXPECT_EQ(read + lost, sample->sequence) << "no sample was read twice";
    EXPECT_EQ(sample->sequence, static_cast<std::uint64_t>(sample->value));
  };
  slow_down(delays.shm);
  while (gecos::line_state(robot).moved_from.empty()) {
    servant_.publish(++published);
    ASSERT_NO_FATAL_FAILURE(read_one());
    std::this_thread::sleep_for(1ms);  // a stream of 1 kHz, which no socket drops
  }
  servant_.publish(++published);
  while (read + lost < static_cast<std::uint64_t>(published)) ASSERT_NO_FATAL_FAILURE(read_one());
  EXPECT_EQ(level->counts().received, read);
  EXPECT_EQ(level->counts().lost, lost);
}

TEST_F(LineFailover, AListenerGoesOnOverTheOtherMediumAndEndsItsWaitThere) {
  const auto robot = create();
  LineWatch watch(robot);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  std::promise<std::int32_t> heard;
  auto listening = gecos::listen(*std::move(level), [&](const gecos::Sample<std::int32_t>& sample) {
    heard.set_value(sample.value);
  });
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  EXPECT_TRUE(settles([&] { return only_over_lcm(robot); })) << "the reader has left shm";
  servant_.publish(5);
  EXPECT_EQ(heard.get_future().get(), 5);
  auto closing = std::async(std::launch::async, [&] { listening.close(); });
  EXPECT_EQ(closing.wait_for(30s), std::future_status::ready);
}

TEST_F(LineFailover, AStreamWhoseWaitsHaveEndedDoesNotWaitOverTheOtherMediumEither) {
  const auto robot = create();
  LineWatch watch(robot);
  const auto core = robot.session()->subscribe(probe::description().streams[0]);
  ASSERT_TRUE(core) << core.error();
  (*core)->stop_waiting();
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  gecos::session::RawSample sample;
  auto read = std::async(std::launch::async,
                         [&] { return (*core)->next(sample, gecos::TimePoint::max()); });
  EXPECT_EQ(read.wait_for(30s), std::future_status::ready);
  servant_.publish(1);  // ends a wait that goes on
  EXPECT_FALSE(read.get());
  EXPECT_TRUE(settles([&] { return only_over_lcm(robot); })) << "it reads over lcm";
}

TEST_F(LineFailover, AHistoryHasTheSamplesOfBothMediaUntilTheReaderHasLeftTheFirst) {
  const auto robot = create();
  LineWatch watch(robot);
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  const auto values = [&] {
    std::vector<std::int32_t> kept;
    for (const auto& sample : level->history()) kept.push_back(sample.value);
    return kept;
  };
  for (const int value : {1, 2, 3}) servant_.publish(value);
  EXPECT_EQ(values(), (std::vector{1, 2, 3}));
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  servant_.publish(4);
  EXPECT_TRUE(settles([&] { return values() == (std::vector{1, 2, 3, 4}); }));
  for (const int value : {1, 2, 3, 4}) EXPECT_EQ(level->next(60s)->value, value);
  EXPECT_TRUE(settles([&] { return only_over_lcm(robot); })) << "the reader has left shm";
  const auto kept = values();
  EXPECT_LE(kept.size(), 2u) << "what lcm has kept since the move: 4, and 3 if it came before";
  EXPECT_EQ(kept.back(), 4);
}

TEST_F(LineFailover, ACallThatRunsEndsInTheSessionThatIssuedIt) {
  std::promise<gecos::IncomingCall> came;
  servant_.on_read([&](gecos::IncomingCall call) { came.set_value(std::move(call)); });
  const auto robot = create();
  LineWatch watch(robot);
  const auto reading = robot.read();
  gecos::IncomingCall call = came.get_future().get();
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  EXPECT_EQ(reading.state(), gecos::State::Running);
  gecos::Bytes result(4);
  gecos::wire::Encoder(result).put(std::int32_t{9});
  call.finish(result);
  EXPECT_EQ(reading.get().value(), 9);
}

TEST_F(LineFailover, TheSessionThatWasLeftEndsWhenNothingUsesItAnyMore) {
  const auto robot = create();
  LineWatch watch(robot);
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  EXPECT_TRUE(settles([&] { return only_over_lcm(robot); }));
}

TEST_F(LineFailover, WithAStatusTheSessionStaysUntilTheStatusIsReleased) {
  servant_.open_gate();
  const auto robot = create();
  LineWatch watch(robot);
  auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.changes, 2u);
  EXPECT_TRUE(stays.degraded);
  EXPECT_EQ(stays.medium, "shm");
  EXPECT_EQ(stays.moved_from, "");
  EXPECT_EQ(stays.why, "PROBE stays on shm: this program has a status or asks for one");
  EXPECT_TRUE(robot.move(1).get()) << "the status counts";
  EXPECT_FALSE(lease->lost());
  lease->release();
  const LineState moved = await(watch, 3);
  EXPECT_EQ(moved.changes, 3u);
  EXPECT_EQ(moved.moved_from, "shm");
  const auto again = gecos::actor(robot);
  ASSERT_TRUE(again) << again.error();
  EXPECT_TRUE(robot.move(2).get()) << "over the new medium, too";
}

TEST_F(LineFailover, ARefusedRequestForAStatusKeepsNoSession) {
  const auto holder = second_lab_.create<probe::Probe>("PROBE");
  ASSERT_TRUE(holder) << holder.error();
  const auto lease = gecos::actor(*holder);
  ASSERT_TRUE(lease) << lease.error();
  const auto robot = create();
  LineWatch watch(robot);
  ASSERT_FALSE(gecos::actor(robot));
  slow_down(delays.shm);
  EXPECT_EQ(await(watch, 2).moved_from, "shm");
}

TEST_F(LineFailover, WithoutAnotherMediumThatMeetsTheBoundTheSessionStays) {
  const auto robot = create();
  LineWatch watch(robot);
  slow_down(delays.lcm);
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.changes, 2u);
  EXPECT_TRUE(stays.degraded);
  EXPECT_EQ(stays.medium, "shm");
  EXPECT_EQ(stays.why.find("PROBE stays on shm: PROBE "), 0u) << stays.why;
  EXPECT_NE(stays.why.find("lcm"), std::string::npos) << stays.why;
  EXPECT_TRUE(robot.read().get()) << "the session goes on";
  delays.shm = 0;
  const LineState recovered = await(watch, 3);
  EXPECT_FALSE(recovered.degraded);
  EXPECT_EQ(recovered.medium, "shm");
  EXPECT_NE(recovered.why.find("again within latency=250ms"), std::string::npos) << recovered.why;
}

TEST_F(LineFailover, WithAStreamThatMustLoseNoSampleTheSessionStaysOffLcm) {
  const auto robot = far_.create<ReliableMobile>("PROBE", {.patience = 20s});
  ASSERT_TRUE(robot) << robot.error();
  LineWatch watch(*robot);
  auto level = robot->level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.medium, "shm");
  EXPECT_EQ(stays.why,
            "PROBE stays on shm: 'level' of PROBE was not opened over lcm: reliability=RELIABLE: "
            "the medium lcm may lose samples, and nothing retransmits them; create the proxy over "
            "another "
            "medium");
  servant_.publish(1);
  EXPECT_EQ(level->next(60s)->value, 1) << "the stream goes on";
}

TEST_F(LineFailover, WithHardRealtimeTheSessionMovesOnlyToAMediumThatTheLabFileCallsRealTime) {
  const probe::WrittenLabFile file;
  for (const bool stated : {false, true}) {
    delays.shm = 0;
    gecos::Lab lab = delayed_lab(file.path());
    const auto robot = lab.create<HardMobile>("PROBE", {.patience = 20s});
    ASSERT_TRUE(robot) << robot.error();
    ASSERT_EQ(medium_of(*robot), "shm");
    LineWatch watch(*robot);
    if (stated) file.write("[media.lcm]\nreal_time = true\n");  // after the session was opened
    slow_down(delays.shm);
    const LineState state = await(watch, 2);
    EXPECT_EQ(state.medium, stated ? "lcm" : "shm") << state.why;
    if (stated) continue;
    EXPECT_NE(state.why.find("PROBE stays on shm: "), std::string::npos) << state.why;
    EXPECT_NE(state.why.find("class=HARD_REALTIME: the medium lcm "), std::string::npos)
        << state.why;
  }
}

TEST_F(LineFailover, TheQualityThatTheProgramRequestedAppliesOverTheOtherMedium) {
  const auto robot =
      far_.create<Mobile>("PROBE", {.quality = {.lifespan = 20min}, .patience = 20s});
  ASSERT_TRUE(robot) << robot.error();
  LineWatch watch(*robot);
  slow_down(delays.shm);
  ASSERT_EQ(await(watch, 2).medium, "lcm");
  auto level = robot->level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  servant_.publish(1, gecos::unix_now_ns() - 3'600'000'000'000);  // measured one hour ago
  servant_.publish(2);
  const auto sample = level->next(60s);
  ASSERT_TRUE(sample) << sample.error();
  EXPECT_EQ(sample->value, 2);
  EXPECT_EQ(level->counts().expired, 1u);
}

TEST_F(LineFailover, TheSessionStaysOffAMediumThatIsNotOfTheRequestedClass) {
  const auto robot = far_.create<Mobile>(
      "PROBE", {.quality = {.line = gecos::qos::Class::HardRealtime}, .patience = 20s});
  ASSERT_TRUE(robot) << robot.error();
  LineWatch watch(*robot);
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.medium, "shm");
  EXPECT_NE(stays.why.find("class=HARD_REALTIME: the medium lcm "), std::string::npos) << stays.why;
}

TEST_F(LineFailover, AProxyWhoseLabHasEndedSaysThatItHasNoLabThatLooksForAnotherMedium) {
  const auto robot = delayed_lab().create<Mobile>("PROBE", {.patience = 20s});
  ASSERT_TRUE(robot) << robot.error();
  LineWatch watch(*robot);
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.medium, "shm");
  EXPECT_EQ(stays.why,
            "PROBE stays on shm: its Lab has ended; keep the Lab while its proxies are used");
}

TEST_F(LineFailover, AMediumThatTheProgramHasChosenIsKept) {
  const auto robot = create(Kind::Shm);
  LineWatch watch(robot);
  slow_down(delays.shm);
  const LineState stays = await(watch, 2);
  EXPECT_EQ(stays.why, "PROBE stays on shm: this program has chosen the medium");
  EXPECT_EQ(medium_of(robot), "shm");
}

TEST_F(LineFailover, ASampleHasTheSameNumberOverAllMedia) {
  const auto near = far_.create<probe::Probe>("PROBE", {.medium = Kind::Shm, .patience = 20s});
  const auto far = far_.create<probe::Probe>("PROBE", {.medium = Kind::Lcm, .patience = 20s});
  ASSERT_TRUE(near && far);
  auto first = near->level(gecos::stream);
  ASSERT_TRUE(first) << first.error();
  for (const int value : {1, 2, 3}) servant_.publish(value);
  auto later = far->level(gecos::stream);
  ASSERT_TRUE(later) << later.error();
  const auto newest = later->next(60s);
  ASSERT_TRUE(newest) << newest.error();
  EXPECT_EQ(newest->value, 3);
  EXPECT_EQ(newest->sequence, 3u);
  servant_.publish(4);
  const auto next = later->next(60s);
  ASSERT_TRUE(next) << next.error();
  EXPECT_EQ(next->sequence, 4u);
  EXPECT_EQ(first->latest()->sequence, 4u);
}

}  // namespace
