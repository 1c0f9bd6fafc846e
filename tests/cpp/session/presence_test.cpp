// An object that the lab file places in a zone moves only while the zone reports that a person is
// present, over every medium.
#include <chrono>
#include <fstream>

#include "../media/scratch_directory.hpp"
#include "await_detail.hpp"
#include "over_media.hpp"
#include "reporting_zone.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;

/// Made before the labs of the test, which read it.
struct LabFileWithZone {
  LabFileWithZone() {
    write("[objects.PROBE]\nzone = \"CELL\"\n");
    setenv("GECOS_LAB_FILE", path.c_str(), 1);
  }
  ~LabFileWithZone() { unsetenv("GECOS_LAB_FILE"); }
  void write(const std::string& text) const { std::ofstream(path) << text; }
  const gecos::media::ScratchDirectory directory;
  const std::string path = directory.path() + "/lab.toml";
};

class Presence : protected LabFileWithZone, public probe::OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    const auto added = zone_server_->add("CELL", zone_, {.simulated = true, .media = {kind_}});
    ASSERT_TRUE(added) << added.error().text;
    robot = connect(lab_);
    lease.emplace(*gecos::actor(robot));
  }
  /// The object knows of the zone and says this.
  bool says(const std::string& text) { return says(robot, text); }
  bool says(const probe::Probe& object, const std::string& text) {
    return settles([&] {
      const auto about = gecos::describe(object).get();
      return about && about->presence.find(text) != std::string::npos;
    });
  }
  void person_comes() {
    zone_.say(true, "anna has checked in");
    ASSERT_TRUE(says("a person is present in zone CELL: anna has checked in"));
  }
  static void expect_lost(const gecos::Command<std::int32_t>& command, const std::string& why) {
    const auto ended = command.get();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, Detail::PresenceLost) << ended.error();
    EXPECT_NE(ended.error().text.find(why), std::string::npos) << ended.error();
  }

  probe::ReportingZone zone_;
  gecos::Lab zone_lab_{probe::patient()};
  std::unique_ptr<gecos::Server> zone_server_ = std::make_unique<gecos::Server>(zone_lab_);
  probe::Probe robot;
  std::optional<gecos::Lease> lease;
};
PROBE_OVER_MEDIA(Presence);

TEST_P(Presence, OfNobodyRefusesCommandsAndNothingElse) {
  ASSERT_TRUE(says("no person has checked in"));
  const auto refused = robot.move(1).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::PresenceLost);
  EXPECT_EQ(refused.error().text,
            "'move' of PROBE was not started: nobody is known to be present in zone CELL: no "
            "person has checked in; check in at CELL");
  EXPECT_EQ(robot.read().get().value(), 7);
  EXPECT_TRUE(robot.urgent().get());
  EXPECT_TRUE(gecos::stop(robot).get());
}

TEST_P(Presence, ThatIsLostStopsWhatRunsAndQueuesAndItsReturnResumesNothing) {
  person_comes();
  const auto runs = robot.move(1);
  const auto waits = robot.set(2);
  servant_.await_moves(1);
  probe::await_detail(waits, Detail::Queued);
  zone_.say(false, "DOOR is open or silent; close it");
  for (const auto& command : {runs, waits}) {
    expect_lost(command,
                "presence was lost: nobody is known to be present in zone CELL: DOOR is open or "
                "silent; close it; nothing resumes by itself");
  }
  servant_.await_event("interrupted 1");
  person_comes();
  EXPECT_EQ(robot.set(3).get().value(), 3) << "the status was kept";
  EXPECT_EQ(servant_.events(), (std::vector<std::string>{"start 1", "interrupted 1", "set 3"}));
}

TEST_P(Presence, OfASilentZoneIsLost) {
  person_comes();
  const auto runs = robot.finish(1);
  servant_.await_moves(1);
  zone_.fall_silent();
  expect_lost(runs, "the zone has been silent for 1 s");
  servant_.await_event("interrupted 1");
}

TEST_P(Presence, ThatWasLostBetweenTwoReportsIsLost) {
  person_comes();
  const auto runs = robot.move(1);
  servant_.await_moves(1);
  zone_.blink();
  expect_lost(runs, "presence was lost: a person is present again in zone CELL");
}

TEST_P(Presence, IsLostWhenAnEditOfTheLabFileMovesTheObjectToAnotherZone) {
  person_comes();
  const auto runs = robot.move(1);
  servant_.await_moves(1);
  write("[objects.PROBE]\nzone = \"HALL\"\n");
  expect_lost(runs, "presence was lost: nobody is known to be present in zone HALL");
  ASSERT_TRUE(says("in zone HALL: the zone cannot be reached"));
  write("[objects.PROBE]\nzone = \"CELL\"\n");
  ASSERT_TRUE(says("a person is present in zone CELL"));
  EXPECT_EQ(robot.set(3).get().value(), 3);
}

TEST_P(Presence, IsNeededByAnObjectThatEntersAZoneAndByOneThatLeavesItsZone) {
  write("[objects.STAYS]\nzone = \"CELL\"\n");
  probe::ProbeServant stays, free;
  gecos::Server its_server(zone_lab_);
  ASSERT_TRUE(its_server.add("STAYS", stays, {.simulated = true, .media = {kind_}}));
  ASSERT_TRUE(its_server.add("FREE", free, {.simulated = true, .media = {kind_}}));
  const auto remains = connect(lab_, "STAYS"), moves = connect(lab_, "FREE");
  const auto lease_of_remains = gecos::actor(remains), lease_of_moves = gecos::actor(moves);
  ASSERT_TRUE(lease_of_remains && lease_of_moves);
  ASSERT_TRUE(says(remains, "no person has checked in"));
  const auto runs = moves.move(1);
  free.await_moves(1);
  write("[objects.FREE]\nzone = \"HALL\"\n");
  expect_lost(runs, "presence was lost: nobody is known to be present in zone HALL");
  ASSERT_TRUE(says(remains, "in zone CELL")) << "it leaves its zone only when it is served anew";
  expect_lost(remains.move(2), "nobody is known to be present in zone CELL");
}

TEST_P(Presence, EndsWithTheServerOfTheZone) {
  person_comes();
  const auto runs = robot.move(1);
  servant_.await_moves(1);
  zone_server_.reset();
  expect_lost(runs, "nobody is known to be present in zone CELL: the ");
  ASSERT_TRUE(says("the zone cannot be reached"));
  expect_lost(robot.move(2), "the zone cannot be reached");
}

}  // namespace
