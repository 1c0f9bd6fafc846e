// What becomes of commands and status when a program dies, in processes of their own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <future>
#include <sstream>
#include <thread>

#include "../media/kind_names.hpp"
#include "../same_bytes.hpp"
#include "await_detail.hpp"
#include "child.hpp"
#include "gecos/gecos.hpp"
#include "gecos/session/process/pause_watch.hpp"
#include "place.hpp"
#include "probe.hpp"

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

gecos::ObjectOptions simulated(Kind kind) {
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  options.media = {kind};
  return options;
}

/// Serves PROBE, and says each time a move has started.
void serve_probe(Child::Line& line, Kind kind) {
  line.hear();
  gecos::Lab lab;
  probe::ProbeServant servant;
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(kind));
  line.say(added ? "ready" : added.error().text);
  servant.await_moves(1);
  line.say("moving");
  line.hear();
}

class ServerDies : public ::testing::TestWithParam<Kind> {
 protected:
  Place place_;
  Child child_{[](Child::Line& line) { serve_probe(line, GetParam()); }};
};
INSTANTIATE_TEST_SUITE_P(Over, ServerDies, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(ServerDies, AndEveryCommandEndsInAStateThatSaysWhatIsKnown) {
  const BrokerHere broker;
  child_.line().say("go");
  ASSERT_EQ(child_.line().hear(), "ready");
  gecos::Lab lab;
  auto robot = lab.create<probe::Probe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  const auto lease = gecos::actor(*robot);
  ASSERT_TRUE(lease) << lease.error();
  auto stream = robot->level(gecos::stream);
  ASSERT_TRUE(stream) << stream.error();
  const auto move = robot->move(1);
  ASSERT_EQ(child_.line().hear(), "moving");
  const auto killed = Clock::now();
  child_.kill_at_once();
  EXPECT_EQ(move.wait(), State::CommandFailed);
  const auto took = Clock::now() - killed;
  if (GetParam() == Kind::Shm) {
    EXPECT_EQ(move.progress().detail, Detail::ServerCrashed);
    EXPECT_LT(took, 500ms) << "the kernel reports it; nobody waits for grace";
  } else {
    EXPECT_EQ(move.progress().detail, Detail::OutcomeUnknown);
    EXPECT_GT(took, gecos::LabOptions{}.grace);
    EXPECT_LT(took, gecos::LabOptions{}.grace + 500ms) << "promised";
  }
  const auto later = robot->read().get();
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().state(), State::ConnectionFailed) << later.error();
  const auto lost = stream->next(1s);
  ASSERT_FALSE(lost);
  std::ostringstream text;
  text << lost.error();
  EXPECT_EQ(text.str(),
            "LOST: the server of the stream is gone or the Lab of the stream is closed; create a "
            "new proxy and "
            "subscribe again");
  EXPECT_TRUE(stream->lost() && !stream->latest());
  EXPECT_EQ(move.state(), State::CommandFailed) << "it never changes";
}

TEST_P(ServerDies, AndAListenerIsToldTheReason) {
  const BrokerHere broker;
  child_.line().say("go");
  ASSERT_EQ(child_.line().hear(), "ready");
  gecos::Lab lab;
  auto robot = lab.create<probe::Probe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  auto level = robot->level(gecos::stream);
  ASSERT_TRUE(level) << level.error();
  std::promise<std::pair<gecos::StreamEnd, std::string>> told;
  const auto listening = gecos::listen(
      *std::move(level), [](const gecos::Sample<std::int32_t>&) {},
      [&](gecos::StreamEnd end, const std::string& why) {
        told.set_value({end, why});
      });
  child_.kill_at_once();
  const auto [end, why] = told.get_future().get();
  EXPECT_EQ(end, gecos::StreamEnd::Lost);
  EXPECT_NE(why.find(GetParam() == Kind::Shm ? "died" : "silent"), std::string::npos) << why;
}

class ServerStandsStill : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    child_.line().say("go");
    ASSERT_EQ(child_.line().hear(), "ready");
  }
  /// As soon as its server can be found: that of a stopped one is forgotten and told again.
  probe::Probe connect() {
    const auto give_up = Clock::now() + 20s;
    for (;;) {
      auto robot = lab_.create<probe::Probe>("PROBE");
      if (robot) return *robot;
      if (Clock::now() > give_up) throw std::runtime_error(robot.error().to_string());
    }
  }
  /// Once nobody else has it, so that nothing of anybody else can still be carried out.
  std::int32_t level_in_the_end() {
    auto robot = connect();
    const auto give_up = Clock::now() + 20s;
    for (;;) {
      const auto lease = gecos::actor(robot);
      if (lease) return robot.read().get().value();
      if (Clock::now() > give_up) throw std::runtime_error(lease.error().failure.text);
    }
  }

  Place place_;
  Child child_{[](Child::Line& line) { serve_probe(line, GetParam()); }};
  const BrokerHere broker_;
  gecos::Lab lab_;
};
INSTANTIATE_TEST_SUITE_P(Over, ServerStandsStill, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(ServerStandsStill, AndWhatItsClientHasGivenUpIsNotCarriedOutLater) {
  auto robot = connect();
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  child_.signal(SIGSTOP);
  std::vector<gecos::Command<std::int32_t>> sent;
  for (int i = 0; i < 40; ++i) sent.push_back(robot.set(100 + i));
  for (const auto& command : sent) {
    static_cast<void>(command.wait());
    // Where the two share memory its start would be marked there, so there was none.
    const bool proved = GetParam() == Kind::Shm;
    EXPECT_EQ(command.progress().detail, proved ? Detail::NotStarted : Detail::OutcomeUnknown);
  }
  child_.signal(SIGCONT);
  EXPECT_EQ(level_in_the_end(), 7);
}

TEST_P(ServerStandsStill, AndWhatItsClientClosedMeanwhileIsNotCarriedOutLater) {
  {
    gecos::Lab closed;
    auto robot = closed.create<probe::Probe>("PROBE");
    ASSERT_TRUE(robot) << robot.error();
    const auto lease = gecos::actor(*robot);
    ASSERT_TRUE(lease) << lease.error();
    child_.signal(SIGSTOP);
    for (int i = 0; i < 40; ++i) static_cast<void>(robot->set(100 + i));
    closed.close();
  }
  child_.signal(SIGCONT);
  EXPECT_EQ(level_in_the_end(), 7);
}

TEST_P(ServerStandsStill, AndWhatAClientHadQueuedThatGaveUpAndLeftIsNotCarriedOutLater) {
  {
    gecos::Lab leaves;
    auto robot = leaves.create<probe::Probe>("PROBE");
    ASSERT_TRUE(robot) << robot.error();
    const auto lease = gecos::actor(*robot);
    ASSERT_TRUE(lease) << lease.error();
    const auto move = robot->move(1);
    ASSERT_EQ(child_.line().hear(), "moving");
    const auto behind = robot->set(100);
    await_detail(behind, Detail::Queued);
    child_.signal(SIGSTOP);
    static_cast<void>(behind.wait());
    const bool proved = GetParam() == Kind::Shm;
    EXPECT_EQ(behind.progress().detail, proved ? Detail::NotStarted : Detail::OutcomeUnknown);
    EXPECT_EQ(move.wait(), State::CommandFailed);
  }
  child_.signal(SIGCONT);
  EXPECT_EQ(level_in_the_end(), 7);
}

TEST_P(ServerStandsStill, AndWhatWasIssuedMeanwhileIsProvedNotToHaveStarted) {
  auto robot = connect();
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  child_.signal(SIGSTOP);
  const auto sent = robot.set(98);
  await_detail(sent, Detail::Unreachable);
  const auto never_sent = robot.set(99);
  EXPECT_EQ(never_sent.wait(), State::ConnectionFailed);
  EXPECT_EQ(never_sent.progress().detail, Detail::NotStarted);
  child_.signal(SIGCONT);
  EXPECT_EQ(level_in_the_end(), 7);
}

TEST_P(ServerStandsStill, AndADeadlineThatPassedMeanwhileHasPassed) {
  auto robot = connect();
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease) << lease.error();
  child_.signal(SIGSTOP);
  const auto sent = gecos::with(robot, {.deadline = 100ms}).set(99);
  EXPECT_EQ(sent.wait_for(500ms), State::Running) << "only its server can say";
  child_.signal(SIGCONT);
  EXPECT_EQ(sent.wait(), State::CommandFailed);
  EXPECT_EQ(sent.progress().detail, Detail::Expired);
  EXPECT_EQ(robot.read().get().value(), 7);
}

/// Takes the robot; when it is told, issues what sets the level, and says so.
void command_stopped_probe(Child::Line& line, Kind kind) {
  line.hear();
  gecos::Lab lab;
  gecos::CreateOptions options;
  options.medium = kind;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  if (!robot) return line.say(robot.error().to_string());
  const auto lease = gecos::actor(*robot);
  line.say(lease ? "actor" : lease.error().failure.text);
  line.hear();
  for (int i = 0; i < 40; ++i) static_cast<void>(robot->set(100 + i));
  line.say("issued");
  line.hear();
}

class BothStandStill : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    server_.line().say("go");
    ASSERT_EQ(server_.line().hear(), "ready");
    client_.line().say("go");
    ASSERT_EQ(client_.line().hear(), "actor");
    server_.signal(SIGSTOP);
    client_.line().say("go");
    ASSERT_EQ(client_.line().hear(), "issued");
  }
  std::int32_t level_of_a_free_robot() {
    const auto give_up = Clock::now() + 20s;
    for (;;) {
      auto robot = lab_.create<probe::Probe>("PROBE");
      if (robot) {
        const auto lease = gecos::actor(*robot);
        if (lease) return robot->read().get().value();
      }
      if (Clock::now() > give_up) throw std::runtime_error("its status does not become free");
    }
  }

  Place place_;
  Child server_{[](Child::Line& line) { serve_probe(line, GetParam()); }};
  Child client_{[](Child::Line& line) { command_stopped_probe(line, GetParam()); }};
  const BrokerHere broker_;
  gecos::Lab lab_;
};
INSTANTIATE_TEST_SUITE_P(Over, BothStandStill, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(BothStandStill, AndWhatADeadClientHadIssuedIsNotCarriedOut) {
  client_.kill_at_once();  // it has given nothing up
  // The pause itself: what the client sent is younger than the server would refuse for its age.
  std::this_thread::sleep_for(gecos::session::PauseWatch::longest_gap + 100ms);
  server_.signal(SIGCONT);
  EXPECT_EQ(level_of_a_free_robot(), 7);
}

/// Takes the robot and moves it; then does what the test asks for.
void command_probe(Child::Line& line, Kind kind) {
  line.hear();
  static gecos::Lab lab;  // ends when the program exits
  gecos::CreateOptions options;
  options.medium = kind;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  static auto lease = gecos::actor(*robot);
  line.say(lease ? "actor" : lease.error().failure.text);
  static_cast<void>(robot->move(1));
  static_cast<void>(robot->set(2));
  line.hear();
}

/// Takes the robot and starts a command that goes on when its caller is lost; queues another one.
void command_probe_to_the_end(Child::Line& line, Kind kind) {
  line.hear();
  gecos::Lab lab;
  gecos::CreateOptions options;
  options.medium = kind;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  const auto lease = gecos::actor(*robot);
  line.say(lease ? "actor" : lease.error().failure.text);
  const auto ends = robot->finish(1);
  const auto never = robot->set(2);
  await_detail(never, Detail::Queued);
  line.say("queued");
  line.hear();
}

/// Joins the status that is shared by a password; then takes over and moves the robot.
void guard_probe(Child::Line& line, Kind kind) {
  line.hear();
  gecos::Lab lab;
  gecos::CreateOptions options;
  options.medium = kind;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  const auto lease = gecos::actor(*robot, "two hands");
  line.say(lease ? "member" : lease.error().failure.text);
  line.hear();
  const auto taken = gecos::take_over(*robot).get();
  line.say(taken ? "taken" : taken.error().text);
  static_cast<void>(robot->move(5));
  static_cast<void>(robot->set(6));
  line.hear();
}

/// Joins the status that is shared by a password. Whenever it is told to, commands the robot and
/// says how that ended.
void share_probe(Child::Line& line, Kind kind) {
  line.hear();
  gecos::Lab lab;
  gecos::CreateOptions options;
  options.medium = kind;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  const auto lease = gecos::actor(*robot, "two hands");
  line.say(lease ? "member" : lease.error().failure.text);
  for (;;) {
    line.hear();
    const auto set = robot->set(3).get();
    std::ostringstream said;
    if (set) {
      said << "done";
    } else {
      said << set.error();
    }
    line.say(said.str());
  }
}

constexpr std::size_t images_asked_for = 60;
constexpr std::size_t image_bytes = 2'000'000;

/// Asks for more images than shm holds. Says how many came once it has been told to take them.
void ask_for_images(Child::Line& line) {
  line.hear();
  gecos::Lab lab;
  gecos::CreateOptions options;
  options.medium = Kind::Shm;
  auto robot = lab.create<probe::Probe>("PROBE", options);
  if (!robot) return line.say(robot.error().to_string());
  std::vector<std::shared_ptr<gecos::session::CommandCore>> images;
  for (std::size_t i = 0; i < images_asked_for; ++i) {
    images.push_back(
        robot->session()->call(probe::operation(probe::read_code), 4,
                               [](gecos::wire::Encoder& to) { to.put(std::int32_t{0}); }, {}));
  }
  line.say("asked");
  line.hear();
  std::size_t came = 0;
  for (const auto& image : images) {
    image->wait_until(gecos::TimePoint::max());
    if (image->progress().detail != Detail::Done) return line.say(image->failure().text);
    came += image->result().size() == image_bytes ? 1 : 0;
  }
  line.say(std::to_string(came) + " images");
}

/// Gives back what `read` brings, after it was told to.
void serve_echo(Child::Line& line) {
  line.hear();
  gecos::Lab lab;
  probe::ProbeServant servant;
  servant.on_read([](gecos::IncomingCall call) {
    const gecos::Bytes echo(call.arguments().begin(), call.arguments().end());
    call.finish(echo);
  });
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(Kind::Shm));
  line.say(added ? "ready" : added.error().text);
  line.hear();
}

std::size_t areas_seen() {
  std::size_t seen = 0;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("memfd:gecos bulk") != std::string::npos) ++seen;
  }
  return seen;
}

TEST(ServerDiesAmongImages, AndEveryCallEndsAndNoMemoryIsLeft) {
  const Place place;
  Child child(serve_echo);
  const BrokerHere broker;
  child.line().say("go");
  ASSERT_EQ(child.line().hear(), "ready");
  const gecos::Bytes image(2'000'000, std::byte{7});
  {
    gecos::LabOptions patient;
    patient.lease_ttl = 20s;
    gecos::Lab lab{patient};
    auto robot = lab.create<probe::Probe>("PROBE");
    ASSERT_TRUE(robot) << robot.error();
    std::vector<std::shared_ptr<gecos::session::CommandCore>> commands;
    const auto call = [&] {
      return robot->session()->call(probe::operation(probe::read_code), image.size(),
                                    [&](gecos::wire::Encoder& to) { to.put_bytes(image); }, {});
    };
    for (int i = 0; i < 20; ++i) commands.push_back(call());
    commands[2]->wait_until(gecos::TimePoint::max());
    EXPECT_EQ(commands[2]->progress().detail, Detail::Done) << commands[2]->failure();
    EXPECT_EQ(areas_seen(), 2u);
    child.signal(SIGSTOP);
    auto refused = call();
    for (; refused->progress().detail == Detail::Sent; refused = call())
      commands.push_back(refused);
    EXPECT_EQ(refused->failure().text,
              "'read' of PROBE was not sent: shm is full of packets that the server has not read "
              "yet; wait for an earlier call to end");
    child.kill_at_once();
    for (const auto& command : commands) {
      command->wait_until(gecos::TimePoint::max());
      const Detail detail = command->progress().detail;
      if (detail == Detail::Done) {
        EXPECT_TRUE(same_bytes(command->result(), image));
      } else {
        EXPECT_TRUE(detail == Detail::ServerCrashed || detail == Detail::NotStarted)
            << command->failure();
      }
    }
  }
  EXPECT_EQ(areas_seen(), 0u);
}

TEST(ClientStandsStillAmongImages, AndTheRepliesThatWaitForItDelayNoOtherClient) {
  const Place place;
  Child slow(ask_for_images);
  const BrokerHere broker;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<gecos::IncomingCall> asked;
  probe::ProbeServant servant;
  servant.on_read([&](gecos::IncomingCall call) {
    if (call.caller().pid == ::getpid()) {
      return call.finish(4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{7}); });
    }
    const std::lock_guard lock(mutex);
    asked.push_back(std::move(call));
    changed.notify_one();
  });
  gecos::LabOptions patient;  // with a client that stands still
  patient.grace = 20s;
  gecos::Lab lab{patient};
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(Kind::Shm));
  ASSERT_TRUE(added) << added.error().text;
  gecos::CreateOptions options;
  options.medium = Kind::Shm;
  const auto robot = lab.create<probe::Probe>("PROBE", options);
  ASSERT_TRUE(robot) << robot.error();
  slow.line().say("go");
  ASSERT_EQ(slow.line().hear(), "asked");
  slow.signal(SIGSTOP);
  {
    std::unique_lock lock(mutex);
    ASSERT_TRUE(changed.wait_for(lock, 20s, [&] { return asked.size() == images_asked_for; }));
    const gecos::Bytes image(image_bytes);
    for (auto& call : asked) call.finish(image);
  }
  const auto read = robot->read();
  ASSERT_EQ(read.wait_for(20s), State::Finished) << "the other client has taken nothing yet";
  EXPECT_EQ(read.get().value(), 7);
  slow.signal(SIGCONT);
  slow.line().say("take them");
  EXPECT_EQ(slow.line().hear(), std::to_string(images_asked_for) + " images");
}

class ClientEnds : public ::testing::TestWithParam<Kind> {
 protected:
  explicit ClientEnds(void (*program)(Child::Line&, Kind) = command_probe)
      : child_([program](Child::Line& line) { program(line, GetParam()); }) {}

  void begin(const gecos::LabOptions& options = {}) {
    broker_.emplace();
    lab_.emplace(options);
    server_.emplace(*lab_);
    const auto added = server_->add("PROBE", servant_, simulated(GetParam()));
    ASSERT_TRUE(added) << added.error().text;
    child_.line().say("go");
    ASSERT_EQ(child_.line().hear(), "actor");
    servant_.await_moves(1);
  }
  /// Status, as soon as it is free.
  tl::expected<gecos::Lease, gecos::LeaseRefusal> take_over() {
    gecos::CreateOptions options;
    options.medium = GetParam();
    auto robot = lab_->create<probe::Probe>("PROBE", options);
    if (!robot) throw std::runtime_error(robot.error().to_string());
    const auto give_up = Clock::now() + 10s;
    for (;;) {
      auto lease = gecos::actor(*robot);
      if (lease || Clock::now() > give_up) return lease;
    }
  }

  void end_in_order() {
    child_.line().say("exit");
    EXPECT_EQ(child_.wait(), 0);
    servant_.open_gate();
    servant_.await_event("set 2");
    EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "end 1", "set 2"}));
  }

  Place place_;
  Child child_;
  probe::ProbeServant servant_;
  std::optional<BrokerHere> broker_;
  std::optional<gecos::Lab> lab_;
  std::optional<gecos::Server> server_;
};
INSTANTIATE_TEST_SUITE_P(Over, ClientEnds, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(ClientEnds, ByKillAndItsStatusIsFreeAndTheArmStands) {
  begin();
  child_.kill_at_once();
  servant_.await_event("interrupted 1");
  const auto lease = take_over();
  EXPECT_TRUE(lease) << lease.error();
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "interrupted 1"}))
      << "what it had queued never starts";
}

class ClientOverShmEnds : public ClientEnds {};
INSTANTIATE_TEST_SUITE_P(Over, ClientOverShmEnds, ::testing::Values(Kind::Shm),
                         gecos::media::name_of);

TEST_P(ClientOverShmEnds, ByKillAndItsStatusIsFreeAtOnceHoweverLongASilentOneWouldKeepIt) {
  gecos::LabOptions patient;
  patient.lease_ttl = 60s;
  begin(patient);
  const auto killed = Clock::now();
  child_.kill_at_once();
  const auto lease = take_over();
  EXPECT_TRUE(lease) << lease.error();
  EXPECT_LT(Clock::now() - killed, patient.lease_ttl / 6) << "the kernel reports the death";
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "interrupted 1"}));
}

class ClientEndsDuringWhatFinishesOnLoss : public ClientEnds {
 protected:
  ClientEndsDuringWhatFinishesOnLoss() : ClientEnds(command_probe_to_the_end) {}
};
INSTANTIATE_TEST_SUITE_P(Over, ClientEndsDuringWhatFinishesOnLoss,
                         ::testing::Values(Kind::Shm, Kind::Lcm), gecos::media::name_of);

TEST_P(ClientEndsDuringWhatFinishesOnLoss, ByKillAndTheCommandFinishesAndWhatWaitedNeverStarts) {
  begin();
  ASSERT_EQ(child_.line().hear(), "queued");
  child_.kill_at_once();
  auto lease = take_over();
  ASSERT_TRUE(lease) << "the loss has been noticed: " << lease.error();
  EXPECT_EQ(servant_.events(), std::vector<std::string>{"start 1"}) << "it still runs";
  servant_.open_gate();
  servant_.await_event("end 1");
  const auto robot = lab_->create<probe::Probe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  lease->release();
  const auto own = gecos::actor(*robot);
  ASSERT_TRUE(own) << own.error();
  EXPECT_EQ(robot->set(3).get().value(), 3) << "the next command was behind it";
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "end 1", "set 3"}));
}

TEST_P(ClientEnds, InOrderWithoutWaitingAndItsCommandsStillRun) {
  begin();
  end_in_order();
  const auto lease = take_over();
  EXPECT_TRUE(lease) << lease.error();
}

class TakerDies : public ::testing::TestWithParam<Kind> {
 protected:
  Place place_;
  Child child_{[](Child::Line& line) { guard_probe(line, GetParam()); }};
};
INSTANTIATE_TEST_SUITE_P(Over, TakerDies, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(TakerDies, AndItsMotionStopsAndTheOthersMayStartNewCommands) {
  const BrokerHere broker;
  probe::ProbeServant servant;
  gecos::Lab lab;
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(GetParam()));
  ASSERT_TRUE(added) << added.error().text;
  gecos::CreateOptions options;
  options.medium = GetParam();
  const auto robot = lab.create<probe::Probe>("PROBE", options);
  ASSERT_TRUE(robot) << robot.error();
  const auto lease = gecos::actor(*robot, "two hands");
  ASSERT_TRUE(lease) << lease.error();
  child_.line().say("go");
  ASSERT_EQ(child_.line().hear(), "member");
  const auto move = robot->move(1);
  servant.await_moves(1);
  child_.line().say("take over");
  ASSERT_EQ(child_.line().hear(), "taken");
  EXPECT_EQ(move.get().error().detail, Detail::Preempted);
  servant.await_moves(2);
  const auto refused = robot->set(2).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Denied) << refused.error();
  child_.kill_at_once();
  servant.await_event("interrupted 5");
  const auto give_up = Clock::now() + 10s;
  while (robot->set(3).get().has_value() == false && Clock::now() < give_up) {
  }
  servant.await_event("set 3");
  EXPECT_EQ(servant.events(), (std::vector<std::string>{"start 1", "interrupted 1", "start 5",
                                                        "interrupted 5", "set 3"}))
      << "nothing resumes, and what the taker had queued never starts";
}

class MemberStandsStill : public ::testing::TestWithParam<Kind> {
 protected:
  Place place_;
  Child silent_{[](Child::Line& line) { share_probe(line, GetParam()); }};
  Child other_{[](Child::Line& line) { share_probe(line, GetParam()); }};
};
INSTANTIATE_TEST_SUITE_P(Over, MemberStandsStill, ::testing::Values(Kind::Shm, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(MemberStandsStill, AndItsNextCommandEndsAsLeaseLostAndNamesWhoHasTheStatus) {
  const BrokerHere broker;
  probe::ProbeServant servant;
  gecos::LabOptions patient;  // the session outlives the status
  patient.grace = 20s;
  gecos::Lab lab{patient};
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(GetParam()));
  ASSERT_TRUE(added) << added.error().text;
  gecos::CreateOptions options;
  options.medium = GetParam();
  const auto robot = lab.create<probe::Probe>("PROBE", options);
  ASSERT_TRUE(robot) << robot.error();
  for (Child* const member : {&silent_, &other_}) {
    member->line().say("go");
    ASSERT_EQ(member->line().hear(), "member");
    member->line().say("command");
    ASSERT_EQ(member->line().hear(), "done");
  }
  silent_.signal(SIGSTOP);
  const auto give_up = Clock::now() + 10s;
  auto holders = gecos::holders(*robot).get();
  while (holders && holders->size() == 2 && Clock::now() < give_up) {
    holders = gecos::holders(*robot).get();
  }
  silent_.signal(SIGCONT);
  ASSERT_TRUE(holders) << holders.error();
  ASSERT_EQ(holders->size(), 1u) << "silence ends a status";
  silent_.line().say("command");
  const std::string said = silent_.line().hear();
  EXPECT_TRUE(said.starts_with("COMMAND_FAILED/LEASE_LOST")) << said;
  EXPECT_NE(said.find("its holder was silent for"), std::string::npos) << said;
  const std::string other = "pid " + std::to_string(holders->front().pid) + ")";
  EXPECT_NE(said.find(other), std::string::npos) << said << " does not name " << other;
  other_.line().say("command");
  EXPECT_EQ(other_.line().hear(), "done") << "it keeps the status";
  servant.await_event("set 3");
  EXPECT_EQ(servant.events(), (std::vector<std::string>(3, "set 3")));
}

struct LabBeforeTheFork {
  LabBeforeTheFork() { const gecos::Lab used; }
};
class ClientForkedByAProcessWithALab : LabBeforeTheFork, public ClientEnds {};
INSTANTIATE_TEST_SUITE_P(Over, ClientForkedByAProcessWithALab,
                         ::testing::Values(Kind::Shm, Kind::Lcm), gecos::media::name_of);

TEST_P(ClientForkedByAProcessWithALab, EndsInOrderToo) {
  begin();
  end_in_order();
}

TEST_P(ClientEnds, ByStandingStillAndLosesItsStatusAfterTheTimeToLive) {
  begin();
  const auto stopped = Clock::now();
  child_.signal(SIGSTOP);
  servant_.await_event("interrupted 1");
  const auto took = Clock::now() - stopped;
  EXPECT_GT(took, 300ms);
  EXPECT_LT(took, 5 * (gecos::LabOptions{}.lease_ttl + gecos::LabOptions{}.heartbeat));
}

TEST(BrokerDies, AndItsSuccessorKnowsTheObjectsAgain) {
  const Place place;
  Child first([](Child::Line& line) {
    const BrokerHere broker;
    line.say("ready");
    line.hear();
  });
  ASSERT_EQ(first.line().hear(), "ready");
  gecos::Lab lab;
  probe::ProbeServant servant;
  gecos::Server server(lab);
  const auto added = server.add("PROBE", servant, simulated(Kind::Inproc));
  ASSERT_TRUE(added) << added.error().text;
  first.kill_at_once();
  const BrokerHere second;
  const auto give_up = Clock::now() + 10s;
  auto robot = lab.create<probe::Probe>("PROBE");
  while (!robot && Clock::now() < give_up) robot = lab.create<probe::Probe>("PROBE");
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_EQ(robot->read().get().value(), 7);
}

TEST(BrokerStands, OnceOnAHostAndSaysSo) {
  const Place place;
  const BrokerHere first;
  gecos::Lab lab;
  gecos::broker::Broker second;
  gecos::Server server(lab);
  const auto served = second.serve(server, {Kind::Shm});
  ASSERT_FALSE(served);
  EXPECT_NE(served.error().text.find("BROKER"), std::string::npos) << served.error().text;
}

}  // namespace
