// Users of one host reach a server of root over shm, if the server admits them. The children become
// other users, so these tests run as root; tests/system/test_two_users.py runs them for others.

#include <gtest/gtest.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "../settles.hpp"
#include "child.hpp"
#include "gecos/base/user_and_host.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/broker_client.hpp"
#include "place.hpp"
#include "probe.hpp"
#include "shared_place.hpp"

namespace {

using probe::become;
using probe::Child;
using probe::SharedPlace;

std::string used(const gecos::Checked<probe::Probe, gecos::CreateError>& created) {
  if (!created) return created.error().to_string();
  auto level = created->level(gecos::stream);
  const auto lease = gecos::actor(*created);
  if (!level || !lease) return "no stream or no status";
  const auto set = created->set(8);
  const auto sample = level->next(std::chrono::seconds(10));
  const bool done = set.wait() == gecos::State::Finished;
  return done && sample ? "read " + std::to_string(sample->value) : "no sample or no end";
}

/// Moves PROBE under a lease and reads its stream until its session ends; then says how it ended.
std::string held_until_the_end(Child::Line& line) {
  gecos::Lab lab;
  const auto created = lab.create<probe::Probe>("PROBE", {.patience = std::chrono::seconds(10)});
  if (!created) return created.error().to_string();
  auto level = created->level(gecos::stream);
  const auto lease = gecos::actor(*created);
  if (!level || !lease) return "no stream or no status";
  const auto move = created->move(1);
  if (!level->next(std::chrono::seconds(10))) return "no sample";
  line.say("holds");
  const auto moved = move.get();
  const auto sample = level->next(std::chrono::seconds(10));
  const bool revoked = !sample && sample.error() == gecos::StreamEnd::Revoked;
  const auto read = created->read().get();
  return (moved ? "moved"
                : std::string(to_string(moved.error().detail)) + ": " + moved.error().text) +
         (revoked ? "; stream REVOKED: " + level->loss_text() + "; " : "; stream goes on; ") +
         (read ? "read" : read.error().text);
}

/// Commands PROBE without having acquired a status.
std::string commanded(const gecos::Checked<probe::Probe, gecos::CreateError>& created) {
  if (!created) return created.error().to_string();
  const auto set = created->set(9).get();
  const std::string outcome =
      set ? "set" : std::string(to_string(set.error().detail)) + ": " + set.error().text;
  return created->read().get() ? outcome : "cannot read";
}

std::string in_one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// Serves OWN and OWN2 until it is told something. Says before what the server logged at its start.
void serve_own(Child::Line& line) {
  ::testing::internal::CaptureStderr();
  gecos::Lab lab;
  probe::ProbeServant one;
  probe::ProbeServant other;
  gecos::Server server{lab};
  server.allow({"bin"});
  std::string logged;
  for (const auto& [name, servant] : {std::pair("OWN", &one), std::pair("OWN2", &other)}) {
    const auto added = server.add(name, *servant, {.media = {gecos::media::Kind::Shm}});
    if (!added) logged += "not served: " + added.error().text;
  }
  logged += ::testing::internal::GetCapturedStderr();
  line.say(in_one_line(logged));
  line.hear();
  line.say("ended");
}

/// A program of `user` that uses or holds PROBE each time it is told to.
void program_of(const std::string& user, Child::Line& line) {
  // The edits of the lab file are about the servers: a client that reads it for the place of the
  // broker finds none while the file has an error.
  ::setenv("GECOS_BROKER", "shm", 1);
  try {
    become(user);
  } catch (const std::runtime_error& why) {
    line.say(why.what());
    return;
  }
  line.say("ready");
  for (;;) {
    const std::string told = line.hear();
    if (told == "serve") {
      serve_own(line);
      continue;
    }
    if (told == "hold") {
      line.say(in_one_line(held_until_the_end(line)));
      continue;
    }
    gecos::Lab lab;
    const auto created = lab.create<probe::Probe>(
        told == "reach" ? "OWN" : "PROBE",
        {.patience = std::chrono::seconds(10),
         .wait = told == "wait" ? std::chrono::milliseconds(300) : std::chrono::milliseconds(0)});
    line.say(in_one_line(told == "command" ? commanded(created) : used(created)));
  }
}

class TwoUsersOfOneHost : public ::testing::Test {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) {
      GTEST_SKIP() << "NOT TRIED here: tests/system/test_two_users.py runs this as root";
    }
    ASSERT_EQ(daemon.line().hear(), "ready");
    ASSERT_EQ(bin.line().hear(), "ready");
  }

  static std::string use(Child& user) {
    user.line().say("use");
    return user.line().hear();
  }

  const SharedPlace place;
  Child daemon{[](Child::Line& line) { program_of("daemon", line); }};
  Child bin{[](Child::Line& line) { program_of("bin", line); }};
};

/// The broker and the server of PROBE, made after the children are forked.
struct Laboratory {
  Laboratory() {
    EXPECT_TRUE(server.add("PROBE", servant, {.media = {gecos::media::Kind::Shm}}));
    servant.publish(8);
  }
  probe::BrokerHere broker;
  gecos::Lab lab;
  probe::ProbeServant servant;
  gecos::Server server{lab};
};

TEST_F(TwoUsersOfOneHost, OneIsAdmittedByTheProgramAndTheOtherIsToldWhyNot) {
  place.write("[objects.BROKER.allow]\nusers = [\"*\"]\n");
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  EXPECT_EQ(use(daemon), "read 8");
  const std::string refused = use(bin);
  EXPECT_EQ(refused.find("PROBE: REFUSED: shm:"), 0u) << refused;
  EXPECT_NE(refused.find("PROBE refuses user bin of host " + gecos::host_name() +
                         ": the list in the program of the server (`allow`, or `users` and "
                         "`hosts` of `serve`) does not name user bin; add \"bin\" to its users"),
            std::string::npos)
      << refused;
}

TEST_F(TwoUsersOfOneHost, NoListGivesAStatusThatTheInterfaceDemands) {
  place.write("[allow]\nusers = [\"*\"]\nhosts = [\"*\"]\n[admin]\nusers = [\"daemon\"]\n");
  Laboratory laboratory;
  laboratory.server.allow({"*"}, {"*"});
  daemon.line().say("command");
  const std::string denied = daemon.line().hear();
  EXPECT_EQ(denied.find("DENIED: 'set' of PROBE needs actor status"), 0u) << denied;
  EXPECT_EQ(laboratory.servant.events(), std::vector<std::string>{});
  EXPECT_EQ(use(daemon), "read 8") << "with the status it is carried out";
}

TEST_F(TwoUsersOfOneHost, AnInsecureServerAdmitsBothWhomNoListNamesAndItsAuditSaysSo) {
  place.write("[objects.BROKER.allow]\nusers = [\"*\"]\n[objects.PROBE.allow]\nusers = []\n");
  {
    const probe::BrokerHere broker;
    gecos::Lab lab;
    probe::ProbeServant servant;
    gecos::Server server(lab, gecos::Admission::Insecure);
    const auto added =
        server.add("PROBE", servant, {.simulated = true, .media = {gecos::media::Kind::Shm}});
    ASSERT_TRUE(added) << added.error();
    servant.publish(8);
    EXPECT_EQ(use(daemon), "read 8");
    EXPECT_EQ(use(bin), "read 8");
  }
  std::ifstream file(place.audit() + "/audit.jsonl");
  const std::string told(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(told.find("\"event\":\"insecure\",\"object\":\"PROBE\""), std::string::npos) << told;
  EXPECT_NE(told.find("PROBE admits user bin of host " + gecos::host_name() +
                      ": the server of the object was started with --insecure"),
            std::string::npos)
      << told;
}

TEST_F(TwoUsersOfOneHost, TheAuditTellsByWhichRuleOneIsAdmittedAndTheOtherRefused) {
  place.write("[objects.BROKER.allow]\nusers = [\"*\"]\n");
  std::string refused;
  {
    Laboratory laboratory;
    laboratory.server.allow({"daemon"});
    EXPECT_EQ(use(daemon), "read 8");
    refused = use(bin);
  }
  const auto at = refused.find("(request ");
  ASSERT_NE(at, std::string::npos) << refused;
  const std::string number = refused.substr(at + 9, refused.find(')', at) - at - 9);
  std::ifstream file(place.audit() + "/audit.jsonl");
  const std::string told(std::istreambuf_iterator<char>(file), {});
  const std::string host = "\"host\":\"" + gecos::host_name() + "\",\"why\":\"PROBE ";
  EXPECT_NE(told.find("\"event\":\"admitted\",\"object\":\"PROBE\",\"user\":\"daemon\"," + host +
                      "admits user daemon"),
            std::string::npos)
      << told;
  EXPECT_NE(told.find("\"event\":\"refused\",\"object\":\"PROBE\",\"request\":\"" + number +
                      "\",\"user\":\"bin\"," + host + "refuses user bin"),
            std::string::npos)
      << told;
}

TEST_F(TwoUsersOfOneHost, NobodyElseIsAdmittedByDefault) {
  const Laboratory laboratory;
  const std::string refused = use(daemon);
  EXPECT_EQ(refused.find("PROBE: NO_SERVER: the broker refuses this program: shm:"), 0u) << refused;
  EXPECT_NE(refused.find("BROKER refuses user daemon of host " + gecos::host_name() +
                         ": BROKER admits only user root of host " + gecos::host_name() +
                         "; write users = [\"daemon\"] below [allow] in " + place.file()),
            std::string::npos)
      << refused;
}

TEST_F(TwoUsersOfOneHost, AWaitThatTheBrokerRefusesGoesOnAndEndsWithTheRefusal) {
  const Laboratory laboratory;
  const auto begun = std::chrono::steady_clock::now();
  daemon.line().say("wait");
  const std::string refused = daemon.line().hear();
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(300));
  EXPECT_EQ(refused.find("PROBE: NO_SERVER: the broker refuses this program: shm:"), 0u) << refused;
}

TEST_F(TwoUsersOfOneHost, AnEditOfTheLabFileActsOnTheNextConnection) {
  place.write("[objects.PROBE.allow]\nusers = [\"daemon\"]\n[allow]\nusers = [\"bin\"]\n");
  const Laboratory laboratory;
  EXPECT_EQ(use(daemon), "read 8");
  EXPECT_NE(use(bin).find("[objects.PROBE.allow] in " + place.file() + ":1 does not name user bin"),
            std::string::npos);
  place.edit("[allow]\nusers = [\"bin\"]\n");
  EXPECT_EQ(use(bin), "read 8");
  EXPECT_NE(use(daemon).find("BROKER refuses user daemon"), std::string::npos);
}

TEST_F(TwoUsersOfOneHost, AnEditThatNoLongerNamesAUserEndsTheSessionOfThatUserAlone) {
  place.write("[allow]\nusers = [\"daemon\", \"bin\"]\n");
  Laboratory laboratory;
  daemon.line().say("hold");
  ASSERT_EQ(daemon.line().hear(), "holds");
  auto own = laboratory.lab.create<probe::Probe>("PROBE", {.patience = std::chrono::seconds(10)});
  ASSERT_TRUE(own) << own.error().to_string();
  auto level = own->level(gecos::stream);
  ASSERT_TRUE(level && level->next(std::chrono::seconds(10)));

  const auto edited = std::chrono::steady_clock::now();
  place.write("[allow]\nusers = [\"bin\"]\n");
  const std::string ended = daemon.line().hear();
  EXPECT_LT(std::chrono::steady_clock::now() - edited, 5 * std::chrono::seconds(5));
  EXPECT_EQ(ended.find("LEASE_LOST: "), 0u) << ended;
  EXPECT_NE(ended.find(" was revoked: PROBE refuses user daemon"), std::string::npos) << ended;
  EXPECT_NE(ended.find("; stream REVOKED: the server closed the session with PROBE: revoked: "),
            std::string::npos)
      << ended;
  EXPECT_NE(
      ended.find("the server closed the session with PROBE: revoked: PROBE refuses user daemon"),
      std::string::npos)
      << ended;
  EXPECT_NE(ended.find("does not name user daemon"), std::string::npos) << ended;
  laboratory.servant.await_event("interrupted 1");
  EXPECT_EQ(use(bin), "read 8") << "the status is free";
  laboratory.servant.publish(9);
  const auto sample = level->next(std::chrono::seconds(10));
  ASSERT_TRUE(sample) << "the stream goes on for the others, in new memory";
  EXPECT_EQ(sample->value, 9);
}

TEST_F(TwoUsersOfOneHost, AFileThatAnEditorHasJustEmptiedChangesNothing) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  const Laboratory laboratory;
  place.write("");
  EXPECT_EQ(use(daemon), "read 8");
}

TEST_F(TwoUsersOfOneHost, ABrokenEditChangesNothingAndIsReportedOnceWithItsLine) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  const Laboratory laboratory;
  ::testing::internal::CaptureStderr();
  place.edit("[allow]\nusers = [\"bin\"]\nuser = []\n");
  EXPECT_EQ(use(daemon), "read 8");
  EXPECT_EQ(use(daemon), "read 8");
  EXPECT_NE(use(bin).find("BROKER refuses user bin"), std::string::npos);
  const std::string logged = ::testing::internal::GetCapturedStderr();
  const std::string report = place.file() + ":3: allow.user: this key is unknown";
  std::size_t reports = 0;
  for (std::size_t at = logged.find(report); at != logged.npos; at = logged.find(report, at + 1)) {
    ++reports;
  }
  EXPECT_EQ(reports, 2u) << "the broker and the server of PROBE report it once each:\n" << logged;
  EXPECT_NE(logged.find("or write an empty one, which removes all its lists"), std::string::npos);
}

TEST_F(TwoUsersOfOneHost, AServerThatAdmitsWhoCannotReachItOverShmSaysSoOnceAndItsClientsAreTold) {
  place.write("[objects.BROKER.allow]\nusers = [\"*\"]\n");
  const Laboratory laboratory;
  daemon.line().say("serve");
  const std::string logged = daemon.line().hear();
  const std::string warning =
      "this server runs as daemon, but the broker runs as another user: programs of users other "
      "than daemon can reach the objects of this server only over lcm, with an admitted key; over "
      "shm they can reach only servers of root and of gecos";
  EXPECT_NE(logged.find(warning), std::string::npos) << logged;
  EXPECT_EQ(logged.find(warning), logged.rfind(warning)) << logged;
  bin.line().say("reach");
  const std::string failed = bin.line().hear();
  EXPECT_NE(
      failed.find(
          "OWN cannot be reached (shm: the server of the object runs as daemon; programs of other "
          "users reach only servers of root and of gecos over shm)"),
      std::string::npos)
      << failed;
  daemon.line().say("end");
  EXPECT_EQ(daemon.line().hear(), "ended");
}

TEST_F(TwoUsersOfOneHost, AServerWhoseUserIsAdmittedAgainIsRegisteredAgain) {
  const std::string admitted = "[objects.BROKER.allow]\nusers = [\"daemon\"]\n";
  place.write(admitted);
  Laboratory laboratory;
  daemon.line().say("serve");
  ASSERT_EQ(daemon.line().hear().find("not served"), std::string::npos);
  const auto registered = [&] {
    return gecos::session::look_up(**gecos::session::LabAccess::context(laboratory.lab), "OWN",
                                   gecos::deadline_after(std::chrono::seconds(10)))
        .has_value();
  };
  ASSERT_TRUE(registered());
  place.edit("[objects.BROKER.allow]\nusers = []\n");
  const auto refused = [&] {
    std::ifstream file(place.audit() + "/audit.jsonl");
    const std::string told(std::istreambuf_iterator<char>(file), {});
    return told.find("\"event\":\"refused\",\"object\":\"BROKER\"") != std::string::npos;
  };
  EXPECT_TRUE(settles(refused));
  EXPECT_TRUE(settles([&] { return !registered(); }));
  place.edit(admitted);
  EXPECT_TRUE(settles(registered)) << "it asks again after 2 s at the latest";
  daemon.line().say("end");
  EXPECT_EQ(daemon.line().hear(), "ended");
}

TEST_F(TwoUsersOfOneHost, TheFolderOfTheServerIsOpenAndTheirsAreNot) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  const Laboratory laboratory;
  EXPECT_EQ(use(daemon), "read 8");
  const std::string shared = ::getenv("GECOS_RUNTIME_DIR");
  const auto mode_of = [](const std::string& path) {
    struct stat found {};
    return ::stat(path.c_str(), &found) == 0 ? found.st_mode & 0777 : 0;
  };
  EXPECT_EQ(mode_of(shared + "/gecos-0"), 0711u);
  EXPECT_EQ(mode_of(shared + "/gecos-0/BROKER.sock"), 0666u);
  EXPECT_EQ(mode_of(shared + "/gecos-" + std::to_string(::getpwnam("daemon")->pw_uid)), 0700u);
}

}  // namespace
