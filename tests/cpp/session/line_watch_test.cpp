// A connection whose delay changes while the program runs.
#include "../media/kind_names.hpp"
#include "../settles.hpp"
#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::LineState;
using gecos::LineWatch;
using gecos::qos::OnDegraded;

constexpr gecos::Duration bound = 250ms;  ///< far above any delay of a busy machine
std::atomic<gecos::Duration::rep> delay{0};

gecos::Lab delayed_line() {
  static const gecos::SystemClock clock;
  const auto wrap = [](std::unique_ptr<gecos::media::Medium> inner) {
    return gecos::media::make_faulty(std::move(inner), {.more_delay = &delay}, clock);
  };
  return gecos::session::LabAccess::with_media(probe::patient(), wrap);
}

gecos::InterfaceDescription demanding(OnDegraded on_degraded) {
  gecos::InterfaceDescription described = probe::description();
  described.quality = {
      .line = gecos::qos::Class::SoftRealtime, .latency = bound, .on_degraded = on_degraded};
  return described;
}

/// What a program has whose interface demands a latency.
template <OnDegraded then>
class Demanding : public probe::Probe {
 public:
  static const gecos::InterfaceDescription& gecos_description() {
    static const gecos::InterfaceDescription described = demanding(then);
    return described;
  }
  Demanding() = default;
  explicit Demanding(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(std::move(session)) {}
};

class Lines : public probe::Bench, public ::testing::WithParamInterface<gecos::media::Kind> {
 protected:
  Lines() : Bench(GetParam()) {}
  void SetUp() override {
    delay = 0;
    Bench::SetUp();
    serve("PROBE", servant_);
  }
  template <OnDegraded then>
  Demanding<then> connect() {
    auto created = far_.create<Demanding<then>>("PROBE", {.medium = kind_});
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Demanding<then>();
  }
  gecos::Lab far_ = delayed_line();
};
INSTANTIATE_TEST_SUITE_P(Over, Lines,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm,
                                           gecos::media::Kind::Lcm),
                         gecos::media::name_of);

TEST_P(Lines, ADelayGivesOneEventAndItsEndAnother) {
  const auto robot = connect<OnDegraded::Event>();
  LineWatch watch(robot);
  ASSERT_TRUE(settles([&] { return gecos::line_state(robot).round_trip.has_value(); }));
  EXPECT_EQ(gecos::line_state(robot).bound, bound);
  EXPECT_FALSE(gecos::line_state(robot).degraded);
  delay = gecos::Duration(600ms).count();
  const auto degraded = watch.next(60s);
  ASSERT_TRUE(degraded);
  EXPECT_TRUE(degraded->degraded);
  EXPECT_EQ(degraded->changes, 1u);
  EXPECT_GT(degraded->round_trip, bound);
  ASSERT_TRUE(robot.read().get()) << "the session goes on";
  delay = 0;
  const auto recovered = watch.next(60s);
  ASSERT_TRUE(recovered);
  EXPECT_FALSE(recovered->degraded);
  EXPECT_EQ(recovered->changes, 2u) << "there was one event of each kind";
}

TEST_P(Lines, TheMeasurementOfCreateStandsUntilAProbeIsAnswered) {
  const auto robot = far_.create<probe::Probe>("PROBE", {.medium = kind_, .latency = 2h});
  ASSERT_TRUE(robot) << robot.error();
  delay = gecos::Duration(1h).count();  // a probe that is sent from now on is never answered
  const auto judged = std::chrono::steady_clock::now() + 300ms;
  do {
    ASSERT_TRUE(gecos::line_state(*robot).round_trip);
  } while (std::chrono::steady_clock::now() < judged);
}

TEST_P(Lines, WithFailTheSessionIsLostAndSaysWhy) {
  const auto robot = connect<OnDegraded::Fail>();
  auto level = robot.level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  LineWatch watch(robot);
  delay = gecos::Duration(600ms).count();
  const auto degraded = watch.next(60s);
  ASSERT_TRUE(degraded);
  EXPECT_TRUE(degraded->degraded);
  EXPECT_FALSE(watch.next(60s)) << "nothing will change any more";
  EXPECT_TRUE(level->lost());
  const auto refused = robot.move(1).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, gecos::Detail::NoServer);
  EXPECT_NE(refused.error().text.find("for one second it has exceeded latency=250ms"),
            std::string::npos)
      << refused.error().text;
}

TEST_P(Lines, PingsAreNoCallsOfTheProgramAndKeepNoSessionOpen) {
  auto robot = std::make_optional(connect<OnDegraded::Event>());
  ASSERT_TRUE(settles([&] { return gecos::line_state(*robot).round_trip.has_value(); }));
  // A ping counts as issued for the moment between its sending and its being known as a ping.
  EXPECT_TRUE(settles([&] { return robot->session()->issued() == 0; }));
  delay = gecos::Duration(1h).count();
  ASSERT_TRUE(settles([&] { return gecos::line_state(*robot).round_trip > bound; }))
      << "one is under way";
  const std::weak_ptr<gecos::session::ClientSession> session = robot->session();
  robot.reset();
  EXPECT_TRUE(settles([&] { return session.expired(); }));
}

TEST_P(Lines, ALatencyThatTheProgramAcceptsIsMeasuredBeforeTheObjectIsUsed) {
  const gecos::CreateOptions accepting{.medium = kind_, .latency = 1h, .patience = 20s};
  const auto robot = far_.create<probe::Probe>("PROBE", accepting);
  ASSERT_TRUE(robot) << robot.error();
  const LineState state = gecos::line_state(*robot);
  EXPECT_EQ(state.bound, 1h);
  EXPECT_TRUE(state.round_trip);
  EXPECT_EQ(robot->session()->issued(), 0u) << "pings are no calls of the program";
}

TEST_P(Lines, WithoutABoundNothingIsMeasured) {
  auto robot = far_.create<probe::Probe>("PROBE", {.medium = kind_});
  ASSERT_TRUE(robot) << robot.error();
  ASSERT_TRUE(gecos::ping(*robot).get());
  const LineState state = gecos::line_state(*robot);
  EXPECT_EQ(state.medium, gecos::media::to_string(kind_));
  EXPECT_EQ(state.bound, 0s);
  EXPECT_FALSE(state.round_trip);
  EXPECT_FALSE(LineWatch(probe::Probe()).next(60s)) << "a nil proxy has no connection";
}

}  // namespace
