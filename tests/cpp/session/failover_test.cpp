// What becomes of @idempotent readings whose server dies: another one carries them out.
#include <gtest/gtest.h>

#include "../media/kind_names.hpp"
#include "await_detail.hpp"
#include "child.hpp"
#include "gecos/gecos.hpp"
#include "hard_probe.hpp"
#include "place.hpp"
#include "probe.hpp"
#include "written_lab_file.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::State;
using gecos::media::Kind;
using probe::await_detail;
using probe::BrokerHere;
using probe::Child;
using probe::Place;
using Clock = std::chrono::steady_clock;

const auto grace = gecos::LabOptions{}.grace;

/// Serves PROBE; says each look that comes. With `answers` it gives 40 and which it was asked for,
/// else nothing, ever.
void serve_probe(Child::Line& line, Kind kind, bool answers, bool simulated = true) {
  line.hear();
  gecos::Lab lab;
  probe::ProbeServant servant;
  std::vector<gecos::IncomingCall> kept;
  servant.on_read([&](gecos::IncomingCall call) {
    gecos::wire::Decoder from(call.arguments());
    std::int32_t which = 0;
    if (!from.get(which, "which")) return;
    line.say("look " + std::to_string(which));
    gecos::Bytes result(sizeof which);
    gecos::wire::Encoder(result).put(which + 40);
    if (answers) return call.finish(result);
    kept.push_back(std::move(call));
  });
  gecos::Server server(lab);
  gecos::ObjectOptions options;
  options.simulated = simulated;
  options.media = {kind};
  const auto added = server.add("PROBE", servant, options);
  line.say(added ? "ready" : added.error().text);
  line.hear();
}

class Failover : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    go(first_);
    auto created = lab_.create<probe::Probe>("PROBE");
    ASSERT_TRUE(created) << created.error();
    robot_ = *created;
  }
  static void go(Child& child) {
    child.line().say("go");
    ASSERT_EQ(child.line().hear(), "ready");
  }

  Place place_;
  Child first_{[](Child::Line& line) { serve_probe(line, GetParam(), false); }};
  Child second_{[](Child::Line& line) { serve_probe(line, GetParam(), true); }};
  const BrokerHere broker_;
  gecos::Lab lab_;
  probe::Probe robot_;
};
INSTANTIATE_TEST_SUITE_P(Over, Failover, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

/// Where it is known at once that a server is gone.
using FailoverOnOneHost = Failover;
INSTANTIATE_TEST_SUITE_P(Over, FailoverOnOneHost, ::testing::Values(Kind::Shm),
                         gecos::media::name_of);

TEST_P(Failover, SendsReadingsAgainThatMayBeAndNothingElse) {
  const auto look = robot_.look(1);
  const auto before = look.id();
  ASSERT_EQ(first_.line().hear(), "look 1");
  const auto other = robot_.look(2);
  ASSERT_EQ(first_.line().hear(), "look 2");
  const auto read = robot_.read();
  ASSERT_EQ(first_.line().hear(), "look 0");
  bool told = false;
  std::mutex mutex;
  std::condition_variable changed;
  other.then([&](const auto& result) {
    const std::lock_guard lock(mutex);
    told = result && *result == 42;
    changed.notify_one();
  });
  first_.kill_at_once();
  go(second_);
  const auto first = look.get();
  ASSERT_TRUE(first) << first.error();
  EXPECT_EQ(*first, 41);
  EXPECT_EQ(second_.line().hear(), "look 1") << "in the order in which they were issued";
  EXPECT_EQ(second_.line().hear(), "look 2");
  EXPECT_NE(look.id(), before) << "it is asked for under another name";
  EXPECT_EQ(read.wait(), State::CommandFailed) << "once at most";
  std::unique_lock lock(mutex);
  EXPECT_TRUE(changed.wait_for(lock, 10s, [&] { return told; }));
}

TEST_P(Failover, ShowsThatNobodyHasItAndEndsWithGraceWhenNobodyComes) {
  const auto look = robot_.look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  const auto killed = Clock::now();
  first_.kill_at_once();
  await_detail(look, Detail::Unreachable);
  EXPECT_EQ(look.wait(), State::CommandFailed);
  const auto took = Clock::now() - killed;
  EXPECT_GE(took, grace - 100ms);
  EXPECT_LT(took, grace + 500ms) << "promised";
  const auto why = look.get().error();
  EXPECT_EQ(why.detail, GetParam() == Kind::Shm ? Detail::ServerCrashed : Detail::OutcomeUnknown)
      << why;
}

TEST_P(FailoverOnOneHost, EndsWithTheDeadlineWhenThatIsEarlier) {
  const auto look = gecos::with(robot_, {.deadline = 300ms}).look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  const auto killed = Clock::now();
  first_.kill_at_once();
  EXPECT_EQ(look.wait(), State::CommandFailed);
  EXPECT_EQ(look.progress().detail, Detail::TimedOut) << look.get().error();
  EXPECT_LT(Clock::now() - killed, grace);
}

TEST_P(FailoverOnOneHost, LeadsToASessionWithTheDeadlineThatTheProgramRequested) {
  const auto brief = lab_.create<probe::Probe>("PROBE", {.quality = {.deadline = 1ns}});
  ASSERT_TRUE(brief) << brief.error();
  const auto patient = gecos::with(*brief, {.deadline = 1h});
  const auto look = patient.look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  first_.kill_at_once();
  go(second_);
  ASSERT_TRUE(look.get());
  EXPECT_FALSE(brief->look(2).get()) << "no call takes so little time";
  EXPECT_EQ(patient.look(3).get().value(), 43);
}

TEST_P(Failover, IsEndedByCancelWhileNobodyHasIt) {
  const auto look = robot_.look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  first_.kill_at_once();
  await_detail(look, Detail::Unreachable);
  look.cancel();
  if (GetParam() == Kind::Shm) {
    EXPECT_EQ(look.progress().detail, Detail::Canceled);
  }
  go(second_);
  look.wait();
  EXPECT_NE(look.progress().detail, Detail::Done) << "it is not sent again";
}

TEST_P(Failover, CarriesReadingsThatAreIssuedLaterAndLeavesTheRestToANewProxy) {
  first_.kill_at_once();
  const auto status = gecos::actor(robot_);
  EXPECT_FALSE(status);
  go(second_);
  EXPECT_EQ(robot_.look(2).get().value(), 42);
  EXPECT_EQ(robot_.look(3).get().value(), 43);
  const auto read = robot_.read().get();
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().detail, Detail::NoServer) << read.error();
}

/// `object.gidl` says that they may be: nothing else does.
TEST_P(Failover, SendsAgainWhatEveryObjectAnswersWhereItsInterfaceAllowsThat) {
  const auto never = robot_.read().id();
  first_.signal(SIGSTOP);
  const auto ping = gecos::ping(robot_);
  const auto described = gecos::describe(robot_);
  const auto holders = gecos::holders(robot_);
  const auto outcome = gecos::outcome(robot_, never);
  const auto stop = gecos::stop(robot_);
  first_.kill_at_once();
  go(second_);
  EXPECT_EQ(ping.wait(), State::Finished) << ping.get().error();
  const auto about = described.get();
  ASSERT_TRUE(about) << about.error();
  EXPECT_EQ(about->name, "PROBE");
  const auto who = holders.get();
  ASSERT_TRUE(who) << who.error();
  EXPECT_TRUE(who->empty());
  const auto what = outcome.get();
  ASSERT_TRUE(what) << what.error();
  EXPECT_EQ(what->detail, Detail::OutcomeUnknown) << "of another process";
  EXPECT_NE(stop.wait(), State::Finished) << "it is not @idempotent";
  EXPECT_EQ(gecos::ping(robot_).wait(), State::Finished) << "issued after the loss";
}

TEST_P(Failover, TakesNoOtherProcessThanTheReferenceSpeaksOf) {
  auto same = lab_.create<probe::Probe>(gecos::reference(robot_));
  ASSERT_TRUE(same) << same.error();
  const auto look = same->look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  first_.kill_at_once();
  go(second_);
  EXPECT_EQ(look.wait(), State::CommandFailed);
}

TEST_P(Failover, EndsWithItsLab) {
  std::optional<gecos::Lab> lab(std::in_place);
  auto robot = lab->create<probe::Probe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  const auto look = robot->look(1);
  ASSERT_EQ(first_.line().hear(), "look 1");
  first_.kill_at_once();
  await_detail(look, Detail::Unreachable);
  lab.reset();
  EXPECT_EQ(look.wait(), State::CommandFailed);
}

TEST(FailoverOfHardRealtime, GoesByWhatTheLabFileStatesThen) {
  const Place place;
  const auto hardware = [](bool answers) {
    return [answers](Child::Line& line) { serve_probe(line, Kind::Shm, answers, false); };
  };
  Child first(hardware(false)), second(hardware(true));
  const BrokerHere broker;
  const probe::WrittenLabFile file;
  gecos::Lab lab({.lab_file = file.path()});
  first.line().say("go");
  ASSERT_EQ(first.line().hear(), "ready");
  const auto robot = lab.create<probe::HardProbe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  const auto look = robot->look(1);
  ASSERT_EQ(first.line().hear(), "look 1");
  file.write("[media.shm]\nreal_time = false\n");
  first.kill_at_once();
  second.line().say("go");
  ASSERT_EQ(second.line().hear(), "ready");
  EXPECT_EQ(look.wait(), State::CommandFailed);
  const std::string why = look.get().error().text;
  EXPECT_NE(why.find("[media.shm] in " + file.path() + ":2 says that shm is not real-time"),
            std::string::npos)
      << why;
}

}  // namespace
