// What the lab file states about media ([media.lcm] real_time = true) decides where HARD_REALTIME
// is possible: first the rule without a file, then a client that reads one.
#include <algorithm>
#include <array>
#include <atomic>
#include <sstream>
#include <thread>
#include <vector>

#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/shm/shm.hpp"
#include "gecos/session/client/select.hpp"
#include "hard_probe.hpp"
#include "written_lab_file.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;
using gecos::qos::Class;
using gecos::qos::Quality;
using gecos::session::demands_hard_real_time;
using gecos::session::line_of;
using gecos::session::StatedMedia;
using probe::HardProbe;

const Quality hard{.line = Class::HardRealtime};

/// Why HARD_REALTIME is not possible over a medium; an empty text when it is.
std::string refusal(const gecos::media::Capabilities& medium, const StatedMedia& stated) {
  return gecos::to_string(gecos::qos::violations(hard, line_of(medium, stated)));
}

TEST(StatedMedia, DecideWhereHardRealtimeIsPossible) {
  const std::string own_word =
      "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose packets";
  const StatedMedia stated = gecos::access::LabMedia{
      {"inproc", {false, "[media.inproc] in lab.toml:2"}},
      {"lcm", {true, "[media.lcm] in lab.toml:4"}},
      {"shm", {false, "[media.shm] in lab.toml:6"}},
  };
  EXPECT_EQ(refusal(gecos::media::inproc_capabilities, stated),
            "class=HARD_REALTIME: [media.inproc] in lab.toml:2 says that inproc is not real-time");
  EXPECT_EQ(refusal(gecos::media::shm_capabilities, stated),
            "class=HARD_REALTIME: [media.shm] in lab.toml:6 says that shm is not real-time");
  EXPECT_EQ(refusal(gecos::media::lcm_capabilities, stated), "");

  EXPECT_EQ(refusal(gecos::media::inproc_capabilities, {}), "");
  EXPECT_EQ(refusal(gecos::media::shm_capabilities, {}), "");
  EXPECT_EQ(refusal(gecos::media::lcm_capabilities, {}), own_word);
}

TEST(StatedMedia, LetNoMediumBeRealTimeWhileTheFileCannotBeUsed) {
  const StatedMedia unusable = tl::unexpected(std::string("the lab file cannot be used"));
  for (const auto& medium : {gecos::media::inproc_capabilities, gecos::media::shm_capabilities,
                             gecos::media::lcm_capabilities}) {
    EXPECT_EQ(refusal(medium, unusable), "class=HARD_REALTIME: the lab file cannot be used");
    EXPECT_TRUE(gecos::qos::violations({}, line_of(medium, unusable)).empty());
  }
}

TEST(DemandsHardRealTime, IsTrueOfAnInterfaceAndOfEachOfItsMembersButNotOfASimulatedDevice) {
  const auto demands = [](const gecos::InterfaceDescription& wanted) {
    EXPECT_FALSE(demands_hard_real_time(wanted, true));
    return demands_hard_real_time(wanted, false);
  };
  const Quality soft{.line = Class::SoftRealtime};
  EXPECT_FALSE(demands({.name = "lab::Lift"}));
  EXPECT_FALSE(demands({.name = "lab::Lift", .quality = soft}));
  EXPECT_TRUE(demands({.name = "lab::Lift", .quality = hard}));
  const std::array operations = {gecos::OperationDescription{.name = "turn", .quality = hard}};
  EXPECT_TRUE(demands({.name = "lab::Lift", .operations = operations}));
  const std::array streams = {gecos::StreamDescription{.name = "height", .quality = hard}};
  EXPECT_TRUE(demands({.name = "lab::Lift", .streams = streams}));
  const std::array inward = {gecos::InwardDescription{.name = "target", .quality = hard}};
  EXPECT_TRUE(demands({.name = "lab::Lift", .inward_streams = inward}));
}

constexpr const char* lcm_is_real_time = "[media.lcm]\nreal_time = true\n";
constexpr const char* shm_is_not = "[media.shm]\nreal_time = false\n";

/// A client with a lab file, and an object that is no simulation.
class MediaOfALabFile : public probe::Bench {
 protected:
  void SetUp() override {
    Bench::SetUp();
    ASSERT_TRUE(server_->add("PROBE", servant_, {.media = {Kind::Shm, Kind::Lcm}}));
  }
  gecos::LabOptions options() const {
    gecos::LabOptions with_file = probe::patient();
    with_file.lab_file = file_.path();
    return with_file;
  }
  template <class P = HardProbe>
  auto create(gecos::CreateOptions how) {
    how.patience = 20s;
    return client_.create<P>("PROBE", how);
  }
  template <class P = HardProbe>
  std::string why_not(gecos::CreateOptions how) {
    const auto created = create<P>(how);
    return created ? "it was created" : created.error().to_string();
  }
  std::string explained() {
    std::ostringstream text;
    const auto told = client_.explain<HardProbe>("PROBE", {.patience = 20s});
    if (told) text << *told;
    return told ? text.str() : told.error().to_string();
  }
  std::string says(const std::string& table, int line, const std::string& what) const {
    return "[media." + table + "] in " + file_.path() + ":" + std::to_string(line) + " says that " +
           table + " is " + what;
  }

  const probe::WrittenLabFile file_;
  gecos::Lab client_{options()};
};

TEST_F(MediaOfALabFile, LetHardRealtimeGoOverLcmWhereTheFileCallsItRealTime) {
  EXPECT_EQ(why_not({.medium = Kind::Lcm}),
            "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; "
            "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose "
            "packets");
  file_.write(lcm_is_real_time);
  const auto robot = create({.medium = Kind::Lcm});
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_EQ(robot->session()->capabilities().name, "lcm");
  EXPECT_EQ(robot->read().get().value(), 7);
  const auto best = create({});
  ASSERT_TRUE(best) << best.error();
  EXPECT_EQ(best->session()->capabilities().name, "shm") << "the order of the media stays";
}

TEST_F(MediaOfALabFile, KeepHardRealtimeFromShmWhereTheFileSaysThatItIsNotRealTime) {
  const auto before = create({.medium = Kind::Shm});
  ASSERT_TRUE(before) << before.error();
  file_.write(shm_is_not);
  EXPECT_EQ(why_not({.medium = Kind::Shm}),
            "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; "
            "class=HARD_REALTIME: " +
                says("shm", 2, "not real-time"));
  EXPECT_EQ(why_not<probe::Probe>({.medium = Kind::Shm}), "it was created") << "it demands nothing";
  EXPECT_EQ(before->read().get().value(), 7) << "a session that is open goes on";
  file_.write(std::string(shm_is_not) + lcm_is_real_time);
  const auto robot = create({});
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_EQ(robot->session()->capabilities().name, "lcm") << "the only one that is left";
}

TEST_F(MediaOfALabFile, CountForHardRealtimeThatTheProgramRequests) {
  const gecos::CreateOptions over_lcm{.medium = Kind::Lcm,
                                      .quality = {.line = Class::HardRealtime}};
  EXPECT_NE(why_not<probe::Probe>(over_lcm).find("class=HARD_REALTIME: the medium lcm "),
            std::string::npos);
  file_.write(lcm_is_real_time);
  EXPECT_EQ(why_not<probe::Probe>(over_lcm), "it was created");
  file_.write(shm_is_not);
  EXPECT_EQ(why_not<probe::Probe>({.quality = {.line = Class::HardRealtime}}),
            "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; "
            "class=HARD_REALTIME: " +
                says("shm", 2, "not real-time") +
                "; class=HARD_REALTIME: the medium lcm shares a queue with other programs and may "
                "lose packets");
}

TEST_F(MediaOfALabFile, CountForTheChannelsInAndOut) {
  file_.write(std::string(shm_is_not) + lcm_is_real_time);
  EXPECT_EQ(why_not({.in = Kind::Shm}),
            "PROBE: QOS_UNAVAILABLE: PROBE (in=shm) no medium meets the required quality; "
            "class=HARD_REALTIME: " +
                says("shm", 2, "not real-time"));
  EXPECT_EQ(why_not({.out = Kind::Shm}),
            "PROBE: QOS_UNAVAILABLE: PROBE (out=shm) no medium meets the required quality; "
            "class=HARD_REALTIME: " +
                says("shm", 2, "not real-time"));
  file_.write(lcm_is_real_time);
  const auto robot = create({.in = Kind::Lcm, .out = Kind::Shm});
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_EQ(robot->read().get().value(), 7);
}

TEST_F(MediaOfALabFile, AreNamedByExplain) {
  EXPECT_EQ(explained().find("says that"), std::string::npos) << explained();
  file_.write(std::string(lcm_is_real_time) + shm_is_not);
  const std::string text = explained();
  EXPECT_NE(text.find("\n  lcm: chosen\n    " + says("lcm", 2, "real-time")), std::string::npos)
      << text;
  EXPECT_NE(text.find("\n  shm: class=HARD_REALTIME: " + says("shm", 4, "not real-time")),
            std::string::npos)
      << text;
}

TEST_F(MediaOfALabFile, RefuseTheCallsOfAMemberThatDemandsHardRealtime) {
  file_.write(shm_is_not);
  std::vector<gecos::OperationDescription> operations(probe::description().operations.begin(),
                                                      probe::description().operations.end());
  const auto read =
      std::ranges::find(operations, probe::read_code, &gecos::OperationDescription::code);
  read->quality = hard;
  gecos::InterfaceDescription wanted = probe::description();
  wanted.operations = operations;
  const auto created = gecos::session::create(gecos::session::LabAccess::context(client_), wanted,
                                              {"PROBE"}, {.medium = Kind::Shm, .patience = 20s});
  ASSERT_TRUE(created) << created.error();
  const auto call = created->session->call(
      *read, 4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{0}); }, {});
  ASSERT_TRUE(call->wait_until(gecos::deadline_after(10s)));
  EXPECT_EQ(call->failure().detail, gecos::Detail::QosUnavailable);
  EXPECT_EQ(call->failure().text, "'read' of PROBE was not sent over shm: class=HARD_REALTIME: " +
                                      says("shm", 2, "not real-time") +
                                      "; create the proxy over another medium");
}

TEST_F(MediaOfALabFile, AreNoneWhileTheFileHasAnErrorAndThenOnlyHardRealtimeIsRefused) {
  file_.write("[media.lmc]\nreal_time = true\n");
  const std::string unusable =
      "class=HARD_REALTIME: the lab file, which may say that a medium is not real-time, cannot be "
      "used: " +
      file_.path() +
      ":1: media.lmc: this key is unknown; known keys are inproc, shm, lcm; correct that";
  EXPECT_EQ(why_not({}),
            "PROBE: QOS_UNAVAILABLE: PROBE no medium meets the required quality; " + unusable)
      << "once for all media";
  EXPECT_NE(explained().find("\n  shm: " + unusable), std::string::npos) << explained();
  EXPECT_EQ(why_not<probe::Probe>({}), "it was created");
  file_.write("");
  EXPECT_EQ(why_not({}), "it was created");
}

TEST_F(MediaOfALabFile, DoNotMatterToASimulatedDevice) {
  probe::ProbeServant second;
  gecos::Server server(server_lab_);
  ASSERT_TRUE(server.add("SIMULATED", second, {.simulated = true, .media = {Kind::Shm}}));
  file_.write("[media.shm]\nreal_time = 0\n");
  const auto created = client_.create<HardProbe>("SIMULATED", {.patience = 20s});
  EXPECT_TRUE(created) << created.error();
}

TEST_F(MediaOfALabFile, AreReadByManyThreadsAtATime) {
  file_.write(std::string(lcm_is_real_time) + shm_is_not);
  gecos::session::LabFileSettings settings(file_.path());
  std::vector<std::thread> threads;
  std::atomic<int> right{0};
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 20; ++k) {
        const auto stated = settings.media(gecos::deadline_after(20s));
        const auto broker = settings.broker(gecos::deadline_after(20s));
        right += stated && stated->size() == 2 && broker && broker->address.empty();
      }
    });
  }
  for (std::thread& each : threads) each.join();
  EXPECT_EQ(right, 8 * 20);
}

}  // namespace
