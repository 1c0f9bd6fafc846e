// The quality that a program requests at `create`, in addition to that of the interface. How the
// terms combine is tested without a session (qos/requested_quality_test).
#include <functional>
#include <mutex>
#include <sstream>

#include "../settles.hpp"
#include "gecos/binding.hpp"
#include "gecos/object_interface.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::StreamEnd;
using gecos::media::Kind;
using gecos::qos::Class;
using gecos::qos::Liveliness;
using gecos::qos::Reliability;
using gecos::qos::StreamCounts;
using Requested = gecos::qos::RequestedQuality;
using Level = gecos::Stream<std::int32_t>;

bool decode(gecos::wire::Decoder& from, std::int32_t& value) { return from.get(value, "value"); }

/// Subscribes to the level as a program does whose interface declares `terms`.
Level level_of(const probe::Probe& robot, const gecos::qos::Quality& terms = {}) {
  gecos::StreamDescription described = probe::description().streams[0];
  described.quality = terms;
  auto core = robot.session()->subscribe(described);
  if (!core) throw std::runtime_error(core.error().text);
  return {*std::move(core), &decode};
}

void publish_old(probe::ProbeServant& servant, std::int32_t value) {
  servant.publish(value, gecos::unix_now_ns() - 3'600'000'000'000);
}

/// Publishes a sample that is one hour old and then a new one. Returns the value of the sample that
/// `level` gives.
std::int32_t first_of_old_and_new(probe::ProbeServant& servant, Level& level) {
  publish_old(servant, 1);
  servant.publish(2);
  const auto sample = level.next(10s);
  if (!sample) throw std::runtime_error(std::string(to_string(sample.error())));
  return sample->value;
}

class RequestedOverMedia : public probe::OverMedia {
 protected:
  void TearDown() override { servant_.on_read({}); }  // drops the calls that the test kept
  probe::Probe create(const Requested& quality) {
    auto created =
        lab_.create<probe::Probe>("PROBE", {.medium = kind_, .quality = quality, .patience = 20s});
    EXPECT_TRUE(created) << created.error();
    return created ? *created : probe::Probe();
  }
};
PROBE_OVER_MEDIA(RequestedOverMedia);

/// Keeps each call of `read` and `look` without an answer.
struct Kept {
  std::mutex mutex;
  std::vector<gecos::IncomingCall> calls;
  bool any() {
    const std::lock_guard lock(mutex);
    return !calls.empty();
  }
};
std::shared_ptr<Kept> keep_calls(probe::ProbeServant& servant) {
  auto kept = std::make_shared<Kept>();
  servant.on_read([kept](gecos::IncomingCall call) {
    const std::lock_guard lock(kept->mutex);
    kept->calls.push_back(std::move(call));
  });
  return kept;
}

/// Returns how a call ends whose handler never finishes. `issue` issues the call with a deadline.
Detail end_of_endless(probe::ProbeServant& servant,
                      const std::function<gecos::Command<std::int32_t>(gecos::Duration)>& issue) {
  const auto kept = keep_calls(servant);
  Detail end{};
  // On a busy machine, a short deadline may pass before the handler begins.
  for (gecos::Duration deadline = 30ms; !kept->any() && deadline < 20s; deadline *= 2) {
    const auto command = issue(deadline);
    command.wait_for(20s);
    end = command.progress().detail;
  }
  return end;
}

TEST_P(RequestedOverMedia, ADeadlineEndsACallWhoseOperationDeclaresNone) {
  EXPECT_EQ(end_of_endless(servant_,
                           [&](auto deadline) { return create({.deadline = deadline}).read(); }),
            Detail::TimedOut);
}

TEST_P(RequestedOverMedia, ADeadlineEndsAReadingThatMayBeSentAgain) {
  EXPECT_EQ(end_of_endless(servant_,
                           [&](auto deadline) { return create({.deadline = deadline}).look(); }),
            Detail::TimedOut);
}

TEST_P(RequestedOverMedia, ALongerDeadlineDoesNotExtendTheDeclaredOne) {
  const auto robot = create({.deadline = 1h});
  EXPECT_EQ(end_of_endless(servant_,
                           [&](auto deadline) {
                             auto read = probe::operation(probe::read_code);
                             read.quality.deadline = deadline;
                             const auto nothing = [](gecos::wire::Encoder& to) {
                               to.put(std::int32_t{0});
                             };
                             return gecos::Command<std::int32_t>(
                                 robot.session()->call(read, 4, nothing, {}), &decode);
                           }),
            Detail::TimedOut);
}

TEST_P(RequestedOverMedia, TheDeadlineOfACallTakesThePlaceOfThatOfCreate) {
  const auto robot = create({.deadline = 1ns});
  EXPECT_FALSE(robot.read().get()) << "no call takes so little time";
  EXPECT_EQ(gecos::with(robot, {.deadline = 1h}).read().get().value(), 7);
}

TEST_P(RequestedOverMedia, ADeadlineIsNotThatOfBuiltInOperations) {
  const auto robot = create({.deadline = 2s});
  const auto& session = dynamic_cast<gecos::session::ClientConnection&>(*robot.session());
  EXPECT_EQ(session.deadline_of(probe::operation(probe::read_code), {}), 2s);
  EXPECT_EQ(session.deadline_of(probe::operation(probe::read_code), {.deadline = 1h}), 1h);
  EXPECT_EQ(session.deadline_of(gecos::GecosObjectInterface::acquire, {}), 0s);
}

TEST_P(RequestedOverMedia, ALifespanWithholdsASampleThatIsOlder) {
  Level brief = level_of(create({.lifespan = 20min}));
  EXPECT_EQ(first_of_old_and_new(servant_, brief), 2);
  EXPECT_EQ(brief.counts(), (StreamCounts{.received = 1, .expired = 1}));
  publish_old(servant_, 3);
  EXPECT_TRUE(settles([&] { return !brief.latest(); })) << "the newest sample is too old";
}

TEST_P(RequestedOverMedia, TheShorterOfTwoLifespansCounts) {
  Level long_lived = level_of(create({}), {.lifespan = 3h});
  EXPECT_EQ(first_of_old_and_new(servant_, long_lived), 1);
  Level declared = level_of(create({.lifespan = 3h}), {.lifespan = 20min});
  ASSERT_TRUE(settles([&] { return declared.latest().has_value(); }));
  EXPECT_EQ(first_of_old_and_new(servant_, declared), 2);
  Level requested = level_of(create({.lifespan = 20min}), {.lifespan = 3h});
  ASSERT_TRUE(settles([&] { return requested.latest().has_value(); }));
  EXPECT_EQ(first_of_old_and_new(servant_, requested), 2);
}

TEST_P(RequestedOverMedia, ADeadlineReportsASilenceOnceAndTheStreamGoesOn) {
  Level strict = level_of(create({.deadline = 20ms}));
  EXPECT_EQ(strict.next(10s).error(), StreamEnd::Late) << "within the deadline, not the patience";
  EXPECT_GE(strict.counts().missed_deadlines, 1u);
  EXPECT_EQ(strict.next(1ms).error(), StreamEnd::Nothing) << "it was told already";
  servant_.publish(1);
  const auto sample = strict.next(10s);
  ASSERT_TRUE(sample) << to_string(sample.error());
  EXPECT_EQ(sample->value, 1);
  EXPECT_TRUE(strict.alive()) << "its process lives";
}

TEST_P(RequestedOverMedia, ALivelinessMakesASilentWriterDead) {
  Level own = level_of(create({.liveliness = Liveliness::Manual}), {.deadline = 20ms});
  servant_.publish(1);
  // Before it a silence may be reported, on a slow machine.
  ASSERT_TRUE(settles([&] { return own.next(10s).has_value(); }));
  EXPECT_EQ(own.next(10s).error(), StreamEnd::Late);
  EXPECT_FALSE(own.alive());
  EXPECT_FALSE(own.latest());
}

class RequestedQuality : public probe::Bench {
 protected:
  void serve_everywhere(bool simulated) {
    gecos::ObjectOptions options;
    options.simulated = simulated;
    const auto added = server_->add("PROBE", servant_, std::move(options));
    ASSERT_TRUE(added) << added.error().text;
  }
  auto create(gecos::CreateOptions options) {
    options.patience = 20s;
    return lab_.create<probe::Probe>("PROBE", options);
  }
  std::string why_not(gecos::CreateOptions options) {
    const auto created = create(std::move(options));
    return created ? "it was created" : created.error().to_string();
  }
};

const std::string no_hard_real_time =
    "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose packets";

TEST_F(RequestedQuality, OfAClassThatNoMediumMeetsRefusesTheCreate) {
  serve_everywhere(false);
  const Requested hard{.line = Class::HardRealtime};
  const auto created = create({.quality = hard});
  ASSERT_TRUE(created) << created.error();
  EXPECT_EQ(created->session()->capabilities().name, "inproc");
  EXPECT_EQ(
      why_not({.medium = Kind::Lcm, .quality = hard}),
      "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; " + no_hard_real_time);
  EXPECT_EQ(why_not({.in = Kind::Lcm, .quality = hard}),
            "PROBE: QOS_UNAVAILABLE: PROBE (in=lcm) no medium meets the required quality; " +
                no_hard_real_time);
  EXPECT_EQ(why_not({.medium = Kind::Lcm, .quality = {.line = Class::SoftRealtime}}),
            "it was created");
}

TEST_F(RequestedQuality, OfAClassAppliesToASimulatedDeviceToo) {
  serve_everywhere(true);
  EXPECT_EQ(
      why_not({.medium = Kind::Lcm, .quality = {.line = Class::HardRealtime}}),
      "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; " + no_hard_real_time);
}

TEST_F(RequestedQuality, ThatIsReliableRefusesTheSamplesOverLcmAlone) {
  serve_everywhere(true);
  const Requested reliable{.reliability = Reliability::Reliable};
  const auto robot = create({.medium = Kind::Lcm, .quality = reliable});
  ASSERT_TRUE(robot) << robot.error();
  const auto refused = robot->level(gecos::stream);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::QosUnavailable);
  EXPECT_EQ(refused.error().text,
            "'level' of PROBE was not opened over lcm: reliability=RELIABLE: the medium lcm may "
            "lose samples, and nothing retransmits them; create the proxy over another medium");
  EXPECT_EQ(robot->read().get().value(), 7) << "the session sends lost calls again";

  const auto over_in = create({.in = Kind::Lcm, .out = Kind::Shm, .quality = reliable});
  ASSERT_TRUE(over_in) << over_in.error();
  EXPECT_FALSE(over_in->level(gecos::stream)) << "its samples come over lcm";

  const auto over_shm = create({.medium = Kind::Shm, .quality = reliable});
  ASSERT_TRUE(over_shm) << over_shm.error();
  EXPECT_TRUE(over_shm->level(gecos::stream));
}

TEST_F(RequestedQuality, ActsOnSamplesThatComeOverAChannelOfTheirOwn) {
  serve_everywhere(true);
  const auto robot = create({.in = Kind::Shm, .out = Kind::Inproc, .quality = {.lifespan = 20min}});
  ASSERT_TRUE(robot) << robot.error();
  Level brief = level_of(*robot);
  EXPECT_EQ(first_of_old_and_new(servant_, brief), 2);
}

TEST_F(RequestedQuality, OfARealTimeClassWatchesTheDeclaredLatency) {
  serve_everywhere(false);
  gecos::InterfaceDescription wanted = probe::description();
  wanted.quality.latency = 1h;
  const auto bound = [&](const Requested& quality) {
    const auto created =
        gecos::session::create(gecos::session::LabAccess::context(lab_), wanted, {"PROBE"},
                               {.medium = Kind::Shm, .quality = quality, .patience = 20s});
    if (!created) throw std::runtime_error(created.error().to_string());
    const gecos::LineState line = created->session->line();
    EXPECT_EQ(line.round_trip.has_value(), line.bound > 0s) << "it is measured if it is limited";
    return line.bound;
  };
  EXPECT_EQ(bound({}), 0s) << "TIME_INDEPENDENT promises nothing about time";
  EXPECT_EQ(bound({.line = Class::SoftRealtime}), 1h);
}

TEST_F(RequestedQuality, DoesNotChangeWhatExplainSays) {
  serve_everywhere(true);
  const auto said = [&](const Requested& quality) {
    std::ostringstream text;
    text << *lab_.explain<probe::Probe>("PROBE", {.quality = quality});
    return text.str();
  };
  EXPECT_EQ(said({.line = Class::HardRealtime, .reliability = Reliability::Reliable}), said({}));
}

}  // namespace
