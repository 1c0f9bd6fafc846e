// Users whom the program of a server admits, and no list of the lab file, reach its objects through
// the broker and do nothing else there. The children become other users, so these tests run as
// root; tests/system/test_two_users.py runs them for others.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>

#include "../settles.hpp"
#include "child.hpp"
#include "gecos/base/user_and_host.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker_client.hpp"
#include "gecos/object_watch.hpp"
#include "place.hpp"
#include "probe.hpp"
#include "shared_place.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;
using probe::become;
using probe::Child;

/// The promise that a revocation acts within 5 s, at five times slack.
constexpr auto promised = 5 * 5s;

std::string in_one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// The names of entries, or of registrations, as "A B ".
std::string names_of(const auto& all) {
  std::string text;
  for (const auto& one : all) {
    if constexpr (requires { one.entry; }) {
      text += one.entry.name + " ";
    } else {
      text += one.name + " ";
    }
  }
  return text;
}

/// A client of the broker, or why there is none.
struct AtBroker {
  explicit AtBroker(gecos::Lab& lab) {
    const auto& context = gecos::session::LabAccess::context(lab);
    auto opened = gecos::session::broker_session(context, gecos::deadline_after(10s));
    if (opened) {
      broker = gecos::Broker(*opened);
    } else {
      refused = opened.error();
    }
  }
  gecos::Broker broker;
  std::string refused;
};

std::string text_of(const auto& outcome) {
  return outcome ? "done" : std::string(to_string(outcome.error().detail));
}

/// What each way to look for objects shows.
std::string looks(gecos::Lab& lab) {
  const AtBroker at(lab);
  if (!at.refused.empty()) return at.refused;
  const gecos::Broker& broker = at.broker;
  const auto listed = broker.list().get();
  const auto queried = broker.query("probe::Probe").get();
  const auto silent = broker.silent().get();
  const auto changed = broker.changes({}).get();
  if (!listed || !queried || !silent || !changed) return "no answer";
  std::string text = "list " + names_of(*listed) + "query " + names_of(*queried) + "silent " +
                     names_of(*silent) + "changes " + names_of(changed->changed) + "lookup ";
  for (const std::string name : {"PROBE", "OTHER"}) {
    const auto found = broker.lookup(name).get();
    const auto unknown = found ? std::nullopt : found.error().as<gecos::UnknownName>();
    text += unknown ? "unknown" : found ? found->name : found.error().text;
    for (const auto& known : unknown ? unknown->known : std::vector<std::string>()) {
      text += ":" + known;
    }
    text += " ";
  }
  return text;
}

/// How each operation at the broker ends.
std::string tries(gecos::Lab& lab) {
  const AtBroker at(lab);
  if (!at.refused.empty()) return at.refused;
  const gecos::Broker& broker = at.broker;
  gecos::Entry mine;
  mine.name = "MINE";
  std::map<std::string, std::vector<std::string>> ends;
  const auto add = [&](const auto& outcome, const char* name) {
    ends[text_of(outcome)].push_back(name);
  };
  add(broker.enlist(mine).get(), "enlist");
  add(broker.withdraw("PROBE").get(), "withdraw");
  add(broker.free("PROBE").get(), "free");
  add(broker.revocations(0).get(), "revocations");
  add(broker.behind({}).get(), "behind");
  add(gecos::stop(broker).get(), "stop");
  add(gecos::holders(broker).get(), "holders");
  add(gecos::roster(broker).get(), "roster");
  add(gecos::stats(broker).get(), "stats");
  add(gecos::requests(broker).get(), "requests");
  add(gecos::break_status(broker, "why").get(), "break_status");
  add(gecos::take_over(broker).get(), "take_over");
  add(gecos::outcome(broker, broker.list().id()).get(), "outcome");
  const auto acquired = gecos::actor(broker);
  ends[acquired ? "done" : std::string(to_string(acquired.error().failure.detail))].push_back(
      "acquire");
  add(gecos::ping(broker).get(), "ping");
  add(gecos::describe(broker).get(), "describe");
  add(gecos::model(broker).get(), "model");
  add(broker.revision().get(), "revision");
  auto revisions = broker.revision(gecos::stream);
  ends[revisions && revisions->next(10s) ? "done" : "no stream"].push_back("stream");
  std::string text;
  for (const auto& [how, names] : ends) {
    text += how + ":";
    for (const auto& name : names) text += " " + name;
    text += "; ";
  }
  return text;
}

std::string used(gecos::Lab& lab) {
  const auto created = lab.create<probe::Probe>("PROBE", {.patience = 10s});
  if (!created) return created.error().to_string();
  const auto read = created->read().get();
  return read ? "read " + std::to_string(*read) : read.error().text;
}

/// Serves MINE, admitting everybody, until its registration ends; then says what comes of it.
std::string serves(gecos::Lab& lab, Child::Line& line) {
  probe::ProbeServant servant;
  gecos::Server server(lab);
  server.allow({"*"}, {"*"});
  if (const auto added = server.add("MINE", servant, {.media = {Kind::Shm}}); !added) {
    return added.error().text;
  }
  line.say("serves");
  return line.hear();
}

/// Registers LIE as the server of another user in the process of PROBE's server, with a list that
/// the lab file does not narrow.
std::string lies(const AtBroker& at) {
  gecos::Entry lie;
  lie.name = "LIE";
  lie.user = "root";
  lie.hostname = "elsewhere";
  const auto known = at.broker.lookup("PROBE").get();
  if (!known) return known.error().text;
  lie.host = known->host;
  lie.pid = known->pid;
  lie.pid_namespace = known->pid_namespace;
  lie.boot = known->boot;
  const auto enlisted = at.broker.enlist(lie, 0, gecos::AdmittedNames{1, {"bin"}, {}}).get();
  return enlisted ? "enlisted" : enlisted.error().text;
}

/// A program of `user` that does what it is told.
void program_of(const std::string& user, Child::Line& line) {
  ::setenv("GECOS_BROKER", "shm", 1);
  try {
    become(user);
  } catch (const std::runtime_error& why) {
    line.say(why.what());
    return;
  }
  line.say("ready");
  std::optional<gecos::Lab> kept;
  for (;;) {
    const std::string told = line.hear();
    gecos::Lab lab;
    std::string said;
    if (told == "use") said = used(lab);
    if (told == "look") said = looks(lab);
    if (told == "try") said = tries(lab);
    if (told == "serve") said = serves(lab, line);
    if (told == "keep") {
      kept.emplace();
      said = looks(*kept);
    }
    if (told == "look kept") said = looks(*kept);
    if (told == "lie") {
      kept.emplace();
      said = lies(AtBroker(*kept));
    }
    if (told == "go on") said = told;
    if (told == "await the end") {
      auto revisions = AtBroker(*kept).broker.revision(gecos::stream);
      if (!revisions) {
        said = revisions.error().text;
      } else {
        const auto until = std::chrono::steady_clock::now() + promised;
        while (revisions->next(1s) || std::chrono::steady_clock::now() < until) {
          if (!revisions->loss_text().empty()) break;
        }
        said = revisions->loss_text();
      }
    }
    line.say(in_one_line(said));
  }
}

class Visitors : public ::testing::Test {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) {
      GTEST_SKIP() << "NOT TRIED here: tests/system/test_two_users.py runs this as root";
    }
    ASSERT_EQ(daemon.line().hear(), "ready");
    ASSERT_EQ(bin.line().hear(), "ready");
  }

  static std::string tell(Child& user, const std::string& what) {
    user.line().say(what);
    return user.line().hear();
  }
  /// The broker knows what a program allows a moment later.
  static bool comes_to_use(Child& user) {
    return settles([&] { return tell(user, "use") == "read 7"; });
  }
  void revoke(const std::string& line) const { std::ofstream(keys_ + "/revoked") << line; }

  const probe::SharedPlace place;
  const std::string keys_ = [this] {
    std::string folder = place.audit() + "-keys";
    ::mkdir(folder.c_str(), 0700);
    ::setenv("GECOS_KEY_DIR", folder.c_str(), 1);
    return folder;
  }();
  Child daemon{[](Child::Line& line) { program_of("daemon", line); }};
  Child bin{[](Child::Line& line) { program_of("bin", line); }};
};

/// The broker, the server of PROBE, and that of OTHER, made after the children are forked.
struct Laboratory {
  Laboratory() {
    EXPECT_TRUE(server.add("PROBE", servant, {.media = {Kind::Shm}}));
    EXPECT_TRUE(other_server.add("OTHER", other, {.media = {Kind::Shm}}));
    servant.publish(8);
  }
  probe::BrokerHere broker;
  gecos::Lab lab;
  probe::ProbeServant servant;
  gecos::Server server{lab};
  probe::ProbeServant other;
  gecos::Server other_server{lab};
};

TEST_F(Visitors, OneWhomTheProgramAloneAdmitsReachesTheObjectAndNobodyElseDoes) {
  Laboratory laboratory;
  EXPECT_NE(tell(daemon, "look").find("BROKER refuses user daemon"), std::string::npos);
  laboratory.server.allow({"daemon"});
  EXPECT_TRUE(comes_to_use(daemon));
  const std::string refused = tell(bin, "look");
  EXPECT_NE(refused.find("BROKER refuses user bin of host"), std::string::npos) << refused;
}

TEST_F(Visitors, AVisitorFindsOnlyTheObjectsThatAdmitTheUser) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_TRUE(comes_to_use(daemon));
  EXPECT_EQ(tell(daemon, "look"),
            "list PROBE query PROBE silent changes PROBE lookup PROBE unknown:PROBE ");
  laboratory.other_server.allow({"*"});
  EXPECT_TRUE(settles([&] {
    return tell(daemon, "look") ==
           "list OTHER PROBE query OTHER PROBE silent changes OTHER PROBE lookup PROBE OTHER ";
  }));
}

TEST_F(Visitors, AVisitorDoesNothingElseAtTheBroker) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_TRUE(comes_to_use(daemon));
  EXPECT_EQ(tell(daemon, "try"),
            "DENIED: enlist withdraw free revocations behind stop holders roster stats requests "
            "break_status take_over outcome acquire; done: ping describe model revision stream; ");
}

TEST_F(Visitors, AListOfTheBrokerKeepsItsMeaning) {
  place.write("[objects.BROKER.allow]\nusers = [\"bin\"]\n");
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_TRUE(settles([&] { return tell(bin, "use").find("PROBE: REFUSED") == 0; }));
  const std::string refused = tell(daemon, "look");
  EXPECT_NE(refused.find("[objects.BROKER.allow] in " + place.file() + ":1 does not name user " +
                         "daemon"),
            std::string::npos)
      << refused;
}

TEST_F(Visitors, AListOfTheBrokersOwnProgramKeepsItsMeaning) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon", "bin"});
  ASSERT_TRUE(comes_to_use(daemon));
  laboratory.broker.server.allow({"bin"});
  EXPECT_EQ(tell(bin, "use"), "read 7");
  const std::string refused = tell(daemon, "look");
  EXPECT_NE(
      refused.find("the list in the program of the server (`allow`, or `users` and `hosts` of "
                   "`serve`) does not name user daemon"),
      std::string::npos)
      << refused;
}

TEST_F(Visitors, AnObjectMakesNoVisitorOfAUserWhomItsListInTheLabFileRefuses) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  laboratory.other_server.allow({"daemon"});
  ASSERT_TRUE(settles([&] { return tell(daemon, "look").find("list OTHER PROBE query") == 0; }));
  place.edit("[objects.PROBE.allow]\nusers = [\"bin\"]\n");
  EXPECT_TRUE(settles([&] { return tell(daemon, "look").find("list OTHER query") == 0; }));
  place.edit("");
  EXPECT_TRUE(settles([&] { return tell(daemon, "look").find("list OTHER PROBE query") == 0; }));
}

TEST_F(Visitors, AVisitorWhomTheProgramAdmitsNoMoreIsSentAway) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  laboratory.other_server.allow({"daemon"});
  ASSERT_TRUE(settles([&] { return tell(daemon, "look").find("list OTHER PROBE ") == 0; }));
  ASSERT_EQ(tell(daemon, "keep").find("list OTHER PROBE "), 0u);
  laboratory.server.allow({});
  EXPECT_TRUE(settles([&] { return tell(daemon, "look").find("list OTHER query") == 0; }));
  laboratory.other_server.allow({"bin"});
  const std::string ended = tell(daemon, "await the end");
  EXPECT_NE(ended.find("revoked: BROKER refuses user daemon"), std::string::npos) << ended;
}

TEST_F(Visitors, ARevokedVisitorIsSentAwayAndNotReceivedAgain) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon", "bin"});
  ASSERT_TRUE(comes_to_use(daemon));
  ASSERT_EQ(tell(daemon, "keep").find("list PROBE "), 0u);
  const auto revoked = std::chrono::steady_clock::now();
  revoke("- daemon@" + gecos::host_name() + "\n");
  const std::string ended = tell(daemon, "await the end");
  EXPECT_LT(std::chrono::steady_clock::now() - revoked, promised);
  const std::string why = "the user who runs the broker has revoked this user";
  EXPECT_NE(ended.find(why), std::string::npos) << ended;
  const std::string refused = tell(daemon, "look");
  EXPECT_NE(refused.find(why), std::string::npos) << refused;
  EXPECT_EQ(tell(bin, "use"), "read 7");
}

TEST_F(Visitors, NobodyIsReceivedWhileItIsNotKnownWhoIsRevoked) {
  revoke("this is no list\n");
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  const std::string why = "at the moment the broker does not know which users are revoked";
  EXPECT_TRUE(settles([&] { return tell(daemon, "look").find(why) != std::string::npos; }));
  revoke("");
  EXPECT_TRUE(settles([&] { return tell(daemon, "look").find("list PROBE ") == 0; }));
}

TEST_F(Visitors, AUserWhomTheLabFileDropsMakesNobodyAVisitorAnyMore) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  Laboratory laboratory;
  ASSERT_EQ(tell(daemon, "lie"), "enlisted");
  ASSERT_TRUE(settles([&] { return tell(bin, "look").find("list LIE query silent") == 0; }));
  place.edit("");
  const auto refused = [&](Child& user, const std::string& name) {
    return tell(user, "look").find("BROKER refuses user " + name) != std::string::npos;
  };
  EXPECT_TRUE(settles([&] { return refused(bin, "bin"); })) << tell(bin, "look");
  const AtBroker at(laboratory.lab);
  const auto silent = at.broker.silent().get();
  ASSERT_TRUE(silent);
  const bool kept = silent->size() == 1 && silent->front().free_in > 0.0;
  EXPECT_TRUE(at.broker.lookup("LIE").get().has_value() || kept)
      << "the list counts no more, although the server has the name";
  EXPECT_TRUE(refused(daemon, "daemon")) << tell(daemon, "look");
}

TEST_F(Visitors, ARegistrationTellsTheUserWhomTheKernelNames) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  Laboratory laboratory;
  ASSERT_EQ(tell(daemon, "lie"), "enlisted");
  const auto found = gecos::find_objects(laboratory.lab);
  ASSERT_TRUE(found) << found.error();
  const auto lie = std::ranges::find(*found, "LIE", &gecos::Entry::name);
  ASSERT_NE(lie, found->end());
  EXPECT_EQ(lie->user + "@" + lie->hostname, "daemon@" + gecos::host_name());
  tell(daemon, "keep");  // ends the session with LIE
  const AtBroker broker(laboratory.lab);
  std::vector<gecos::SilentObject> silent;
  ASSERT_TRUE(settles([&] {
    silent = broker.broker.silent().get().value();
    return silent.size() == 1;
  }));
  EXPECT_TRUE(silent[0].free_in) << "the process of another server does not keep the name";
}

TEST_F(Visitors, ASessionThatBecomesThatOfAVisitorEndsAndItsObjectsLeaveTheList) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_EQ(tell(daemon, "serve"), "serves");
  const auto listed = [&] {
    const auto found = gecos::find_objects(laboratory.lab);
    return found ? names_of(*found) : found.error();
  };
  ASSERT_EQ(listed(), "MINE OTHER PROBE ");
  place.edit("");
  EXPECT_TRUE(settles([&] { return listed() == "OTHER PROBE "; })) << listed();
  daemon.line().say("go on");
  ASSERT_EQ(daemon.line().hear(), "go on");
  EXPECT_EQ(tell(daemon, "look").find("list PROBE query PROBE "), 0u);
}

TEST_F(Visitors, AUserWhomTheLabFileDropsIsToldToConnectAgainAsAVisitor) {
  place.write("[allow]\nusers = [\"daemon\"]\n");
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_EQ(tell(daemon, "keep").find("list OTHER PROBE query"), 0u);
  place.edit("");
  const std::string ended = tell(daemon, "await the end");
  EXPECT_NE(ended.find("revoked: the lab file no longer names user daemon of host " +
                       gecos::host_name() + "; connect again as a visitor"),
            std::string::npos)
      << ended;
}

TEST_F(Visitors, AVisitorWhomTheLabFileNamesDoesEverythingInTheSameSession) {
  Laboratory laboratory;
  laboratory.server.allow({"daemon"});
  ASSERT_TRUE(comes_to_use(daemon));
  ASSERT_EQ(tell(daemon, "keep").find("list PROBE query"), 0u);
  place.edit("[allow]\nusers = [\"daemon\"]\n");
  EXPECT_TRUE(settles([&] { return tell(daemon, "look kept").find("list OTHER PROBE") == 0; }));
}

/// Serves PROBE as root, in a process that can be suspended.
void server_of_probe(Child::Line& line) {
  ::setenv("GECOS_BROKER", "shm", 1);
  line.hear();
  gecos::Lab lab;
  probe::ProbeServant servant;
  gecos::Server server(lab);
  server.allow({"daemon"});
  const auto added = server.add("PROBE", servant, {.media = {Kind::Shm}});
  line.say(added ? "serves" : added.error().text);
  line.hear();
}

class SilentServer : public Visitors {
 protected:
  Child server{[](Child::Line& line) { server_of_probe(line); }};
};

TEST_F(SilentServer, AServerThatIsSilentKeepsItsVisitorsUntilItsProcessEnds) {
  const probe::BrokerHere broker;
  ASSERT_EQ(tell(server, "serve"), "serves");
  ASSERT_TRUE(settles([&] { return tell(daemon, "keep").find("list PROBE ") == 0; }));
  server.signal(SIGSTOP);
  EXPECT_TRUE(settles([&] {
    return tell(daemon, "look kept").find("list query silent PROBE changes PROBE ") == 0;
  }));
  server.kill_at_once();
  const std::string ended = tell(daemon, "await the end");
  EXPECT_NE(ended.find("revoked: BROKER refuses user daemon"), std::string::npos) << ended;
}

}  // namespace
