// The access lists in the text of a lab file, its errors, and edits while a server runs.

#include "gecos/access/lab_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace gecos::access {
namespace {

const std::string path = "lab.toml";
constexpr std::array<std::string_view, 3> media = {"inproc", "shm", "lcm"};

LabAccess lists_in(const std::string& text) {
  auto lists = parse_lab_file(text, path, media);
  EXPECT_TRUE(lists) << to_string(lists.error());
  return lists.value_or(LabAccess{});
}

std::string error_in(const std::string& text) {
  const auto lists = parse_lab_file(text, path, media);
  return lists ? "no error" : to_string(lists.error());
}

TEST(LabFile, NamesWhoIsAdmittedInGeneralAndToAnObject) {
  const LabAccess lists = lists_in(R"(# a laboratory
[broker]
start = true
[programs.RX90]
run = ["robcl-rx90"]
ready = ""
environment = { ANY = "thing" }

[allow]
users = ["anna", "bob"]
hosts = ["bench1"]

[objects.RX90.allow]
users = ["anna"]

[admin]
users = ["eve"]
)");
  ASSERT_TRUE(lists.admin);
  EXPECT_EQ(lists.admin->users, std::vector<std::string>{"eve"});
  ASSERT_TRUE(lists.general);
  EXPECT_EQ(lists.general->users, (std::vector<std::string>{"anna", "bob"}));
  EXPECT_EQ(lists.general->hosts, std::vector<std::string>{"bench1"});
  EXPECT_EQ(lists.general->place, "[allow] in lab.toml:9");
  ASSERT_TRUE(lists.objects.contains("RX90"));
  EXPECT_EQ(lists.objects.at("RX90").users, std::vector<std::string>{"anna"});
  EXPECT_TRUE(lists.objects.at("RX90").hosts.empty());
  EXPECT_EQ(lists.objects.at("RX90").place, "[objects.RX90.allow] in lab.toml:13");
}

TEST(LabFile, BindsSourcesOfZonesToUsers) {
  const LabAccess lab = lists_in("[objects.CELL.sources]\nDOOR = \"door@gate\"\n");
  ASSERT_TRUE(lab.sources.contains("CELL"));
  EXPECT_EQ(lab.sources.at("CELL").at("DOOR").owner, (UserAtHost{"door", "gate"}));
  EXPECT_EQ(lab.sources.at("CELL").at("DOOR").place, "[objects.CELL.sources] in lab.toml:2");
  EXPECT_EQ(error_in("[objects.CELL.sources]\nDOOR = \"door\"\n"),
            "lab.toml:2: objects.CELL.sources.DOOR: a user and a host are expected, for example "
            "DOOR = \"robcl@cell\"");
}

TEST(LabFile, WithACommentInAHeaderHasAnError) {
  EXPECT_NE(error_in("[#allow]\nusers = []\n").find("lab.toml:1: this is not TOML"),
            std::string::npos);
}

TEST(LabFile, BindsNamesOfObjectsToUsers) {
  const LabAccess lab = lists_in("[names]\nRX90 = \"robcl@cell\"\n\"a b\" = \"uid 7@desk.lab\"\n");
  ASSERT_EQ(lab.names.size(), 2u);
  EXPECT_EQ(lab.names.at("RX90").owner, (UserAtHost{"robcl", "cell"}));
  EXPECT_EQ(lab.names.at("RX90").place, "[names] in lab.toml:2");
  EXPECT_EQ(lab.names.at("a b").owner, (UserAtHost{"uid 7", "desk.lab"}));
}

TEST(LabFile, RefusesAnOwnerThatIsNotOneUserOfOneHost) {
  for (const char* owner : {"7", "\"robcl\"", "\"@cell\"", "\"robcl@\"", "\"a@b@c\"", "\"*@cell\"",
                            "[\"robcl@cell\"]", "{ user = \"robcl\" }", "\"\""}) {
    EXPECT_EQ(error_in("[names]\nRX90 = " + std::string(owner)),
              "lab.toml:2: names.RX90: a user and a host are expected, for example RX90 = "
              "\"robcl@cell\"");
  }
  EXPECT_EQ(error_in("names = 1"), "lab.toml:1: names: a table is expected");
  EXPECT_EQ(error_in("[names]\nBROKER = \"robcl@cell\""),
            "lab.toml:2: names.BROKER: the broker is not registered under a name, so this line has "
            "no effect; remove it: each client decides by key or user which brokers it trusts");
}

TEST(LabFile, PlacesObjectsInZones) {
  const auto lab = lists_in("[objects.RX90]\nzone = \"CELL\"\n[objects.LDS.allow]\nusers = []\n");
  EXPECT_EQ(lab.zones, (std::map<std::string, std::string>{{"RX90", "CELL"}}));
  EXPECT_FALSE(lab.objects.contains("RX90")) << "a zone admits nobody";
  EXPECT_TRUE(lab.objects.contains("LDS"));
}

TEST(LabFile, ForbidsOpenStreams) {
  EXPECT_EQ(lists_in("[allow]\nusers = []\n[streams]\nopen = false\n").forbids_open_streams,
            "[streams] in lab.toml:4");
  for (const char* text : {"", "[streams]\n", "[streams]\nopen = true\n"}) {
    EXPECT_EQ(lists_in(text).forbids_open_streams, "") << text;
  }
}

TEST(LabFile, WithoutListsAdmitsNobodyBeyondTheUserOfTheServer) {
  EXPECT_FALSE(lists_in("").general);
  EXPECT_TRUE(lists_in("[programs.A]\nrun = [\"a\"]\n").objects.empty());
}

TEST(LabFile, SaysTheLineOfEachErrorAndWhatToWrite) {
  const std::string too_long = "[allow]\nhosts = [\"" + std::string(257, 'a') + "\"]";
  const std::pair<const char*, const char*> errors[] = {
      {"\n[alow]\nusers = []", "lab.toml:2: alow: this key is unknown; did you mean allow?"},
      {"[allow]\n\nuser = [\"anna\"]",
       "lab.toml:3: allow.user: this key is unknown; did you mean users?"},
      {"[allow]\nusers = []\nfriends = []",
       "lab.toml:3: allow.friends: this key is unknown; known keys are hosts, users"},
      {"[objects.RX90.allow]\nuser = []",
       "lab.toml:2: objects.RX90.allow.user: this key is unknown; did you mean users?"},
      {"[objects.RX90]\npassword = \"two hands\"",
       "lab.toml:2: objects.RX90.password: this key is unknown; known keys are allow, sources, "
       "zone"},
      {"[objects.RX90]\nalow = []",
       "lab.toml:2: objects.RX90.alow: this key is unknown; did you mean allow?"},
      {"[objects.RX90]\nzone = 1",
       "lab.toml:2: objects.RX90.zone: the name of a zone is expected, for example zone = "
       "\"CELL\""},
      {"[objects.CELL]\nzone = \"CELL\"",
       "lab.toml:2: objects.CELL.zone: a zone cannot be in itself; remove this line"},
      {"[objects.BROKER]\nzone = \"CELL\"",
       "lab.toml:2: objects.BROKER.zone: the broker moves nothing, so it needs no zone; remove "
       "this line"},
      {"[clock]\nsped = 10", "lab.toml:2: clock.sped: this key is unknown; did you mean speed?"},
      {"clock = 10", "lab.toml:1: clock: a table is expected"},
      {"[broker]\nadress = \"shm\"",
       "lab.toml:2: broker.adress: this key is unknown; did you mean address?"},
      {"[broker]\nstart = \"yes\"", "lab.toml:2: broker.start: true or false is expected"},
      {"[broker]\naddress = 7",
       "lab.toml:2: broker.address: the address of a broker is expected, for example address = "
       "\"lcm\""},
      {"[broker]\naddress = \"\"",
       "lab.toml:2: broker.address: the address of a broker is expected, for example address = "
       "\"lcm\""},
      {"[broker]\nstart = true\naddress = \"lcm\"",
       "lab.toml:3: broker.address: this address names a broker that runs already, but "
       "`start = true` starts one; leave out `address` or `start`"},
      {"[programs.GRIPPER]\nrun = [\"g\"]\nrestrat = true",
       "lab.toml:3: programs.GRIPPER.restrat: this key is unknown; did you mean restart?"},
      {"[allow]\nusers = \"anna\"",
       "lab.toml:2: allow.users: a list of names is expected, for example users = [\"anna\"]"},
      {"[allow]\nhosts = [\n  \"cell\",\n  4 ]",
       "lab.toml:4: allow.hosts: a list of names is expected, for example hosts = [\"anna\"]"},
      {"[allow]\nusers = [\"\"]",
       "lab.toml:2: allow.users: a name is empty; a list of names is expected, for example users = "
       "[\"anna\"]"},
      {"[allow]\nusers = [\"anna\", \"a\\u0000b\"]",
       "lab.toml:2: allow.users: a name has a control character; a list of names is expected, for "
       "example users = [\"anna\"]"},
      {too_long.c_str(),
       "lab.toml:2: allow.hosts: a name has more than 256 bytes; a list of names is expected, for "
       "example hosts = [\"anna\"]"},
      {"[allow]\nusers = [\"anna\", \"*\"]",
       "lab.toml:2: allow.users: \"*\" admits all names, so the other names have no effect; remove "
       "\"*\" or the others"},
      {"[allow]\n",
       "lab.toml:1: allow: this table is empty; write users = [] if only the user of the server "
       "may connect"},
      {"[broker]\n\n[objects.RX90]\n",
       "lab.toml:3: objects.RX90: this table is empty; write users = […] below "
       "[objects.RX90.allow], or zone = \"…\""},
      {"[streams]\nopen = \"no\"", "lab.toml:2: streams.open: true or false is expected"},
      {"[streams]\nclosed = true",
       "lab.toml:2: streams.closed: this key is unknown; known keys are open"},
      {"streams = false", "lab.toml:1: streams: a table is expected"},
      {"[media.lmc]\nreal_time = true",
       "lab.toml:1: media.lmc: this key is unknown; known keys are inproc, shm, lcm"},
      {"[media.shn]\nreal_time = true",
       "lab.toml:1: media.shn: this key is unknown; did you mean shm?"},
      {"[media.lcm]\nrealtime = true",
       "lab.toml:2: media.lcm.realtime: this key is unknown; did you mean real_time?"},
      {"[media.lcm]\nreal_time = \"yes\"",
       "lab.toml:2: media.lcm.real_time: true or false is expected"},
      {"[media.shm]\nreal_time = true\n[media.lcm]\n",
       "lab.toml:3: media.lcm: this table is empty; write real_time = true or real_time = false"},
      {"[media]\nlcm = true", "lab.toml:2: media.lcm: a table is expected"},
      {"media = [\"lcm\"]", "lab.toml:1: media: a table is expected"},
      {"[medium.lcm]\nreal_time = true",
       "lab.toml:1: medium: this key is unknown; known keys are admin, allow, broker, clock, "
       "media, names, objects, programs, streams"},
      {"allow = 3", "lab.toml:1: allow: a table is expected"},
      {"objects = []", "lab.toml:1: objects: a table is expected"},
      {"[objects]\nRX90 = 1", "lab.toml:2: objects.RX90: a table is expected"},
  };
  for (const auto& [text, expected] : errors) EXPECT_EQ(error_in(text), expected) << text;
  EXPECT_EQ(error_in("[allow]\nusers = [\"anna\"").substr(0, 32),
            "lab.toml:2: this is not TOML: Er");
}

TEST(LabFile, SaysWhereTheBrokerIs) {
  const auto named = parse_lab_broker("[broker]\nstart = false\naddress = \"lcm\"\n", path);
  ASSERT_TRUE(named) << to_string(named.error());
  EXPECT_EQ(named->address, "lcm");
  EXPECT_EQ(named->place, "[broker] in lab.toml:3");
  for (const char* const text : {"", "[broker]\nstart = true", "[broker]\nstart = false"}) {
    const auto none = parse_lab_broker(text, path);
    ASSERT_TRUE(none) << to_string(none.error());
    EXPECT_EQ(none->address + none->place, "") << text;
  }
}

TEST(LabFile, WithAnUnknownTableDoesNotSayWhereTheBrokerIs) {
  const auto broker = parse_lab_broker("[brokr]\naddress = \"lcm\"\n", path);
  ASSERT_FALSE(broker);
  EXPECT_EQ(to_string(broker.error()),
            "lab.toml:1: brokr: this key is unknown; did you mean broker?");
}

TEST(LabFile, WithAnErrorInAListSaysWhereTheBrokerIs) {
  const auto broker =
      parse_lab_broker("[allow]\nuser = \"anna\"\n[broker]\naddress = \"lcm\"\n", path);
  ASSERT_TRUE(broker) << to_string(broker.error());
  EXPECT_EQ(broker->address, "lcm");
}

LabMedia media_in(const std::string& text) {
  auto stated = parse_lab_media(text, path, media);
  EXPECT_TRUE(stated) << to_string(stated.error());
  return stated.value_or(LabMedia{});
}

TEST(LabFile, SaysWhichMediaAreRealTime) {
  const LabMedia stated =
      media_in("[media.lcm]\nreal_time = true\n\n[media.shm]\n# a VM\nreal_time = false\n");
  ASSERT_EQ(stated.size(), 2u);
  EXPECT_TRUE(stated.at("lcm").real_time);
  EXPECT_EQ(stated.at("lcm").place, "[media.lcm] in lab.toml:2");
  EXPECT_FALSE(stated.at("shm").real_time);
  EXPECT_EQ(stated.at("shm").place, "[media.shm] in lab.toml:6");
  for (const char* const text : {"", "[media]\n", "[broker]\naddress = \"lcm\"\n"}) {
    EXPECT_TRUE(media_in(text).empty()) << text;
  }
}

TEST(LabFile, WithAnErrorInAListSaysWhichMediaAreRealTime) {
  const LabMedia stated = media_in("[allow]\nuser = \"anna\"\n[media.lcm]\nreal_time = true\n");
  EXPECT_TRUE(stated.contains("lcm"));
}

TEST(LabFile, WithAnErrorInMediaOrAnUnknownTableSaysNothingAboutMedia) {
  for (const auto& [text, why] :
       {std::pair("[media.lcm]\nreal_time = 1\n",
                  "lab.toml:2: media.lcm.real_time: true or false is expected"),
        {"[meda.lcm]\nreal_time = true\n",
         "lab.toml:1: meda: this key is unknown; did you mean media?"}}) {
    const auto stated = parse_lab_media(text, path, media);
    ASSERT_FALSE(stated) << text;
    EXPECT_EQ(to_string(stated.error()), why);
  }
}

TEST(LabFile, WithAnErrorInMediaSaysWhereTheBrokerIs) {
  const auto broker =
      parse_lab_broker("[media.lmc]\nreal_time = true\n[broker]\naddress = \"lcm\"\n", path);
  ASSERT_TRUE(broker) << to_string(broker.error());
  EXPECT_EQ(broker->address, "lcm");
}

// Edits

LabFileError missing() { return {path, 0, "", "the file cannot be read"}; }

TEST(EditedLabFile, KeepsTheListsOfTheLastTextWithoutAnError) {
  EditedLabFile file(path, media);
  EXPECT_FALSE(file.known());
  EXPECT_FALSE(file.take("[allow]\nusers = [\"anna\"]"));
  EXPECT_TRUE(file.known());
  EXPECT_FALSE(file.error());
  const auto broken = file.take("[allow]\nusers = [\"bob\"");
  ASSERT_TRUE(broken);
  EXPECT_TRUE(file.error());
  EXPECT_EQ(broken->line, 2u);
  EXPECT_EQ(file.lists().general->users, std::vector<std::string>{"anna"});
  EXPECT_FALSE(file.take("[allow]\nusers = [\"bob\"")) << "reported already";
  EXPECT_TRUE(file.error()) << "it is still there";
  ASSERT_TRUE(file.take(tl::unexpected(missing())));
  EXPECT_EQ(file.lists().general->users, std::vector<std::string>{"anna"});
  EXPECT_FALSE(file.take("[allow]\nusers = [\"bob\"]"));
  EXPECT_FALSE(file.error());
  EXPECT_EQ(file.lists().general->users, std::vector<std::string>{"bob"});
}

TEST(EditedLabFile, AgreesWithAModelOverAHundredThousandRandomSchedules) {
  const std::vector<EditedLabFile::Text> texts{"[allow]\nusers = [\"anna\"]",
                                               "[allow]\nusers = [\"bob\"]",
                                               "[allow]\nusers = [",
                                               "[allow]\nuser = []",
                                               "",
                                               tl::unexpected(missing())};
  const std::vector<std::optional<std::string>> user_of{"anna",       "bob", std::nullopt,
                                                        std::nullopt, "",    std::nullopt};
  std::mt19937_64 random(16);
  std::size_t reports = 0;
  for (int schedule = 0; schedule < 100'000; ++schedule) {
    EditedLabFile file(path, media);
    std::string in_force;
    std::size_t last = texts.size();
    for (int edit = 0; edit < 4; ++edit) {
      const std::size_t now = random() % texts.size();
      const auto report = file.take(texts[now]);
      ASSERT_EQ(report.has_value(), now != last && !user_of[now]) << schedule << "." << edit;
      reports += report.has_value();
      if (user_of[now]) in_force = *user_of[now];
      last = now;
      const auto& general = file.lists().general;
      ASSERT_EQ(general ? general->users.front() : "", in_force) << schedule << "." << edit;
    }
  }
  EXPECT_GT(reports, 80'000u);
}

}  // namespace
}  // namespace gecos::access
