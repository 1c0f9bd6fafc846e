// The files that say who may connect lie on a file system that does not answer, or are being
// written while they are read.

#include "file_system.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

#include "../media/scratch_directory.hpp"
#include "bench.hpp"
#include "gecos/media/sealed/keys.hpp"
#include "gecos/session/server/access_control.hpp"
#include "hard_probe.hpp"
#include "reporting_zone.hpp"

namespace {

std::shared_ptr<const gecos::session::BrokerContact> without_broker() {
  static const gecos::SystemClock clock;
  return std::make_shared<const gecos::session::BrokerContact>(clock);
}

using namespace std::chrono_literals;
using gecos::Detail;
using gecos::media::Kind;

/// A lab file, which the environment names to all labs that are made later.
struct WithLabFile {
  WithLabFile() {
    write("");
    ::setenv("GECOS_LAB_FILE", lab_file.c_str(), 1);
  }
  ~WithLabFile() { ::unsetenv("GECOS_LAB_FILE"); }
  /// Writes the file as if nobody had changed it for a minute since.
  void write(const std::string& text) const {
    std::ofstream(lab_file) << text;
    std::filesystem::last_write_time(lab_file, std::filesystem::last_write_time(lab_file) - 1min);
  }
  const gecos::media::ScratchDirectory directory;
  const std::string lab_file = directory.path() + "/lab.toml";
};

/// Nobody reads the file but the test.
class TheLabFile : protected WithLabFile, public ::testing::Test {};

class ALabFileThatDoesNotAnswer : protected WithLabFile, public probe::Bench {};

TEST_F(ALabFileThatDoesNotAnswer, DelaysNeitherDeadlinesNorHeartbeats) {
  serve("PROBE", servant_);
  const auto robot = connect(lab_);
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease);
  probe::HangingFiles hanging(lab_file);
  hanging.await_reader();
  const auto moves = gecos::with(robot, {.deadline = 100ms}).move(1);
  ASSERT_EQ(moves.wait_for(10s), gecos::State::CommandFailed) << "the server stands still";
  EXPECT_EQ(moves.get().error().detail, Detail::TimedOut) << moves.get().error();
  EXPECT_EQ(robot.set(2).get().value(), 2) << "the status is kept";
}

TEST_F(TheLabFile, ThatDoesNotAnswerLeavesDecisionsToTheListsThatWereReadLast) {
  write("[allow]\nusers = [\"anna\"]\nhosts = [\"desk\"]\n");
  gecos::session::AccessControl access(lab_file, gecos::Admission::Listed, without_broker());
  ASSERT_TRUE(access.read());
  gecos::media::Peer anna, ben;
  anna.user = "anna", ben.user = "ben";
  anna.host = ben.host = "desk";
  const probe::HangingFiles hanging(lab_file);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(access.judge("PROBE", anna).admitted);
  EXPECT_LT(std::chrono::steady_clock::now() - began, 5 * 250ms);
  EXPECT_FALSE(access.judge("PROBE", ben).admitted);
  EXPECT_FALSE(access.administers(ben));
  EXPECT_NE(access.judge_registration("PROBE", anna).text.find("does not answer"),
            std::string::npos)
      << "it might bind the name to another server";
}

TEST_F(ALabFileThatDoesNotAnswer, LetsNoFurtherObjectBeServed) {
  serve("PROBE", servant_);
  probe::ProbeServant second;
  const probe::HangingFiles hanging(lab_file);
  const auto added = server_->add("SECOND", second, {.simulated = true, .media = {kind_}});
  ASSERT_FALSE(added) << "the file might place it in a zone";
  EXPECT_NE(added.error().text.find(lab_file + ": the file cannot be read: its file system does "
                                               "not answer"),
            std::string::npos)
      << added.error();
}

TEST_F(TheLabFile, ThatDoesNotAnswerDelaysNoSearchOfABrokerBeyondItsPatience) {
  gecos::Lab lab;
  const probe::HangingFiles hanging(lab_file);
  for (int search = 0; search < 2; ++search) {
    const auto began = std::chrono::steady_clock::now();
    const auto created = lab.create<probe::Probe>("PROBE", {.patience = 100ms});
    EXPECT_LT(std::chrono::steady_clock::now() - began, 5 * 100ms);
    ASSERT_FALSE(created) << "the file might name another broker";
    EXPECT_NE(created.error().to_string().find(lab_file + ": its file system does not answer"),
              std::string::npos)
        << created.error();
  }
}

TEST_F(ALabFileThatDoesNotAnswer, RefusesHardRealtimeWithinItsPatienceAndIsReadForNothingElse) {
  ASSERT_TRUE(server_->add("PROBE", servant_, {.media = {kind_}}));
  ASSERT_TRUE(lab_.create<probe::HardProbe>("PROBE", {.patience = 20s}));
  const probe::HangingFiles hanging(lab_file);
  const auto began = std::chrono::steady_clock::now();
  const auto created = lab_.create<probe::HardProbe>("PROBE", {.patience = 100ms});
  EXPECT_LT(std::chrono::steady_clock::now() - began, 5 * 100ms);
  ASSERT_FALSE(created) << "the file might say that the medium is not real-time";
  EXPECT_NE(created.error().to_string().find(
                "class=HARD_REALTIME: the lab file, which may say that a medium is not real-time, "
                "cannot be used: " +
                lab_file + ": its file system does not answer; correct that"),
            std::string::npos)
      << created.error();
  const auto other = lab_.create<probe::Probe>("PROBE", {.patience = 1h});
  EXPECT_TRUE(other) << other.error();
}

TEST_F(TheLabFile, ThatIsBeingWrittenNamesTheBrokerWhenItIsComplete) {
  probe::at_next_open(lab_file, [&] {
    std::ofstream(lab_file) << "[broker]\n";
    probe::at_next_open(lab_file, [&] {
      std::ofstream(lab_file, std::ios::app) << "address = \"inproc:of_file\"\n";
    });
  });
  gecos::Lab lab;
  const auto created = lab.create<probe::Probe>("PROBE", {.patience = 5s});
  ASSERT_FALSE(created);
  EXPECT_NE(created.error().to_string().find("tried inproc:of_file"), std::string::npos)
      << created.error();
}

class AnEditOfTheLabFile : protected WithLabFile, public probe::Bench {};

TEST_F(AnEditOfTheLabFile, CountsAtOnceForAnObjectThatIsAddedAfterIt) {
  probe::ProbeServant second;
  gecos::Server server(server_lab_);
  const gecos::ObjectOptions options{.simulated = true, .media = {kind_}};
  ASSERT_TRUE(server.add("FIRST", servant_, options));
  std::ofstream(lab_file) << "[objects.SECOND]\nzone = \"CELL\"\n";
  ASSERT_TRUE(server.add("SECOND", second, options));
  const auto about = gecos::describe(connect(lab_, "SECOND")).get();
  ASSERT_TRUE(about);
  EXPECT_NE(about->presence.find("in zone CELL"), std::string::npos) << about->presence;
}

TEST_F(TheLabFile, ThatIsBeingWrittenIsReadWhenItIsComplete) {
  for (const char* const begun : {"", "[allow]\nusers = []\n"}) {
    probe::at_next_open(lab_file, [&] {
      std::ofstream(lab_file) << begun;
      probe::at_next_open(lab_file, [&] {
        std::ofstream(lab_file, std::ios::app) << "[objects.SECOND]\nzones = \"CELL\"\n";
      });
    });
    gecos::session::AccessControl access(lab_file, gecos::Admission::Listed, without_broker());
    const auto read = access.read();
    ASSERT_FALSE(read) << "begun: " << begun;
    EXPECT_NE(read.error().find("did you mean zone?"), std::string::npos) << read.error();
  }
}

TEST_F(TheLabFile, ThatIsWrittenWhileItIsReadIsNotTakenHalf) {
  write("[allow]\nusers = []\n");
  probe::at_next_read(lab_file, [&] {
    std::ofstream(lab_file) << "[objects.SECOND]\n";
    probe::at_next_open(lab_file,
                        [&] { std::ofstream(lab_file, std::ios::app) << "zone = \"CELL\"\n"; });
  });
  gecos::session::AccessControl access(lab_file, gecos::Admission::Listed, without_broker());
  ASSERT_TRUE(access.read());
  EXPECT_EQ(access.zone_of("SECOND"), "CELL");
}

TEST_F(AnEditOfTheLabFile, ThatCannotBeFollowedLeavesAnObjectInItsZone) {
  write("[objects.PROBE]\nzone = \"CELL\"\n");
  probe::ReportingZone zone;
  gecos::Server zone_server(second_lab_);
  ASSERT_TRUE(zone_server.add("CELL", zone, {.simulated = true, .media = {kind_}}));
  serve("PROBE", servant_);
  const auto robot = connect(lab_);
  const auto says = [&](const std::string& text) {
    return settles([&] {
      const auto about = gecos::describe(robot).get();
      return about && about->presence.find(text) != std::string::npos;
    });
  };
  ASSERT_TRUE(says("in zone CELL: no person has checked in"));
  probe::NoThreads none;
  write("[objects.PROBE]\nzone = \"HALL\"\n");
  none.await_try();
  zone.say(true, "ben has checked in");
  EXPECT_TRUE(says("a person is present in zone CELL: ben has checked in"));
}

class KeyFilesThatDoNotAnswer : protected WithLabFile, public probe::Bench {
 protected:
  KeyFilesThatDoNotAnswer() : Bench(Kind::Lcm) {}
  void admit(const std::string& whom, const std::string& by) const {
    const auto key = gecos::media::SealedKeys::open(whom).value()->own.public_key();
    ASSERT_NE(gecos::media::SealedKeys::open(by).value(), nullptr);
    const std::string file = "/" + key.to_string() + ".public";
    std::filesystem::copy(whom + file, by + file);
  }
};

TEST_F(KeyFilesThatDoNotAnswer, DelayNeitherDeadlinesNorHeartbeats) {
  const std::string ada = directory.path() + "/ada", bob = directory.path() + "/bob";
  admit(ada, bob);
  admit(bob, ada);
  ::setenv("GECOS_KEY_DIR", ada.c_str(), 1);
  serve("PROBE", servant_);
  ::setenv("GECOS_KEY_DIR", bob.c_str(), 1);
  const auto robot = connect(lab_);
  ::unsetenv("GECOS_KEY_DIR");
  const auto lease = gecos::actor(robot);
  ASSERT_TRUE(lease);
  probe::HangingFiles hanging(ada);
  hanging.await_reader();
  const auto moves = gecos::with(robot, {.deadline = 100ms}).move(1);
  ASSERT_EQ(moves.wait_for(10s), gecos::State::CommandFailed) << "the server stands still";
  EXPECT_EQ(moves.get().error().detail, Detail::TimedOut) << moves.get().error();
  EXPECT_EQ(robot.set(2).get().value(), 2) << "the status is kept";
}

}  // namespace
