// The lines of the audit, which of them are counted, and the files that they are written to.
#include "gecos/audit/audit.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "../media/scratch_directory.hpp"
#include "gecos/audit/folder.hpp"
#include "gecos/audit/repeats.hpp"

namespace gecos::audit {
namespace {

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

Line command(std::uint64_t counter, std::int64_t time = 1000) {
  return {.event = "command", .time = time, .request = {0xa, 0xb, counter}};
}

TEST(AuditLine, NamesTheEventAndWhatIsKnownOfIt) {
  const Line line{.event = "command",
                  .time = 1'795'820'462'007,
                  .object = "RX90",
                  .request = {0x1a2b, 0x3c4d, 31},
                  .operation = "move",
                  .outcome = "DENIED",
                  .why = "needs actor status",
                  .user = "ben",
                  .host = "desk",
                  .program = "lift.py",
                  .pid = 12};
  EXPECT_EQ(to_json(line),
            "{\"time\":\"2026-11-27T23:01:02.007Z\",\"event\":\"command\",\"object\":\"RX90\","
            "\"request\":\"1a2b-3c4d-1f\",\"operation\":\"move\",\"outcome\":\"DENIED\","
            "\"user\":\"ben\",\"host\":\"desk\",\"program\":\"lift.py\",\"pid\":12,"
            "\"why\":\"needs actor status\"}\n");
}

TEST(AuditLine, IsOneLineWhateverAClientSaysOfItself) {
  const std::string text =
      to_json({.event = "connected", .user = "a\"b\\c\n\x01", .program = std::string(2000, 'x')});
  EXPECT_NE(text.find("\"user\":\"a\\\"b\\\\c\\u000a\\u0001\""), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  EXPECT_LT(text.size(), 1200u);
}

TEST(AuditLine, CutsALongTextBetweenTwoCharacters) {
  std::string euros = "x";
  while (euros.size() < 2000) euros += "\u20ac";
  const std::string text = to_json({.event = "refused", .why = euros});
  EXPECT_EQ(text.substr(text.size() - 6), "\u20ac\"}\n") << text;
}

TEST(Repeats, GiveTheFirstEventALineAndCountThoseOfTheNextSecond) {
  Repeats repeats;
  const Repeats::Key done{1, 2, 3};
  EXPECT_FALSE(repeats.count(done, 7));
  repeats.begin(done, command(7));
  EXPECT_TRUE(repeats.count(done, 9));
  EXPECT_TRUE(repeats.count(done, 12));
  EXPECT_TRUE(repeats.due(1999).empty());
  const auto due = repeats.due(2000);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].request.counter, 9u);
  EXPECT_EQ(due[0].last, 12u);
  EXPECT_EQ(due[0].count, 2u);
  EXPECT_EQ(due[0].time, 2000);
  EXPECT_FALSE(repeats.count(done, 13)) << "the next one has a line of its own again";
}

TEST(Repeats, DoNotMixClientsOperationsOrOutcomes) {
  Repeats repeats;
  repeats.begin({1, 2, 3}, command(7));
  for (const Repeats::Key& other : {Repeats::Key{9, 2, 3}, {1, 9, 3}, {1, 2, 9}}) {
    EXPECT_FALSE(repeats.count(other, 8));
  }
  EXPECT_TRUE(repeats.due(5000).empty()) << "nothing was repeated";
}

TEST(Repeats, LoseNothingWhenThereAreTooManyKindsOrTheClockIsSetBack) {
  Repeats repeats;
  for (std::uint64_t session = 0; session < Repeats::most + 1; ++session) {
    repeats.begin({session, 0, 0}, command(1));
  }
  EXPECT_FALSE(repeats.count({Repeats::most, 0, 0}, 2)) << "the caller writes a line for each";
  EXPECT_TRUE(repeats.count({0, 0, 0}, 2));
  EXPECT_EQ(repeats.due(10).size(), 1u);
}

/// The number of lines about an event that happens every `pause` for an hour.
std::size_t lines_in_an_hour(std::int64_t pause) {
  Repeats repeats;
  const Repeats::Key refusal{1, 2, 3};
  std::size_t lines = 0;
  std::uint64_t told = 0;
  std::uint64_t happened = 0;
  for (std::int64_t now = 0; now < 3'600'000; now += 20) {
    if (now % pause == 0 && !repeats.count(refusal, ++happened)) {
      repeats.begin(refusal, command(happened, now), Repeats::Window::Growing);
      ++lines;
      ++told;
    }
    for (const Line& line : repeats.due(now)) {
      ++lines;
      told += line.count;
    }
  }
  for (const Line& line : repeats.all(3'600'000)) told += line.count;
  EXPECT_EQ(told, happened) << "each event is in one line";
  return lines;
}

TEST(Repeats, InGrowingWindowsAddAboutALineAMinuteHoweverOftenTheEventHappens) {
  EXPECT_LE(lines_in_an_hour(20), 1u + 6u + 60u);
  EXPECT_LE(lines_in_an_hour(200), 1u + 6u + 60u);
  EXPECT_LE(lines_in_an_hour(1100), 1u + 6u + 60u) << "an event that just misses the first window";
  EXPECT_LE(lines_in_an_hour(50'000), 3600u / 50u + 1u) << "no more lines than events";
}

TEST(Repeats, InGrowingWindowsTellSoonOfTheFirstRepetitions) {
  Repeats repeats;
  repeats.begin({}, command(7), Repeats::Window::Growing);
  EXPECT_TRUE(repeats.count({}, 8));
  EXPECT_EQ(repeats.due(2000).size(), 1u);
  EXPECT_TRUE(repeats.count({}, 9));
  EXPECT_TRUE(repeats.due(3999).empty()) << "the next window is twice as long";
  const auto due = repeats.due(4000);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].request.counter, 9u);
  EXPECT_EQ(due[0].last, 9u);
  EXPECT_EQ(due[0].count, 1u);
  EXPECT_TRUE(repeats.due(63'999).empty());
  EXPECT_TRUE(repeats.count({}, 10)) << "it is kept for a minute";
  EXPECT_EQ(repeats.due(64'000).size(), 1u);
  EXPECT_TRUE(repeats.due(124'000).empty());
  EXPECT_FALSE(repeats.count({}, 11)) << "after a minute without the event";
}

TEST(Repeats, InGrowingWindowsLoseNothingWhenTheClockIsSetBack) {
  Repeats repeats;
  repeats.begin({}, command(7, 5000), Repeats::Window::Growing);
  EXPECT_TRUE(repeats.count({}, 8));
  EXPECT_EQ(repeats.due(10).size(), 1u);
  EXPECT_TRUE(repeats.count({}, 9));
  EXPECT_TRUE(repeats.due(1009).empty());
  EXPECT_EQ(repeats.due(2010).size(), 1u);
}

TEST(Repeats, TellOfTheTimeUntilWhichTheyCounted) {
  Repeats repeats;
  repeats.begin({}, command(7, 5000), Repeats::Window::Growing);
  EXPECT_TRUE(repeats.count({}, 8));
  const auto rest = repeats.all(5900);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].time, 5900);
}

TEST(Repeats, OfKindsThatAreCountedAtOneTimeEndEachInItsOrder) {
  Repeats repeats;
  repeats.begin({1, 0, 0}, command(1, 1000));
  repeats.begin({2, 0, 0}, command(1, 1500));
  for (const std::uint64_t kind : {1, 2}) EXPECT_TRUE(repeats.count({kind, 0, 0}, 2));
  EXPECT_EQ(repeats.due(2000).size(), 1u);
  EXPECT_FALSE(repeats.count({1, 0, 0}, 3)) << "its window is over";
  repeats.begin({3, 0, 0}, command(1, 2500));
  for (const std::uint64_t counter : {2, 3}) EXPECT_TRUE(repeats.count({3, 0, 0}, counter));
  EXPECT_EQ(repeats.due(2500).size(), 1u);
  EXPECT_TRUE(repeats.due(3499).empty());
  const auto due = repeats.due(3500);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].count, 2u);
}

TEST(Repeats, CompareTheTextOfAKeyWhateverItsNumbersAre) {
  Repeats repeats;
  repeats.begin({0, 5, 0, "one"}, command(7));
  EXPECT_FALSE(repeats.count({0, 5, 0, "other"}, 8));
  EXPECT_TRUE(repeats.count({0, 5, 0, "one"}, 8));
}

class JournalTest : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder_ + "/" + name; }

  media::ScratchDirectory scratch_;
  const std::string folder_ = scratch_.path() + "/state/gecos/audit";
};

TEST_F(JournalTest, MakesItsFoldersAndItsFileForThisUserAlone) {
  Journal journal(folder_);
  ASSERT_TRUE(journal.append("one\n"));
  ASSERT_TRUE(journal.append("two\n"));
  EXPECT_EQ(lines_of(file("audit.jsonl")), (std::vector<std::string>{"one", "two"}));
  struct stat found {};
  ASSERT_EQ(::stat(file("audit.jsonl").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 07777, 0600u);
  ASSERT_EQ(::stat(folder_.c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 07777, 0700u);
}

TEST_F(JournalTest, KeepsTheNewestFiles) {
  Journal journal(folder_, {.bytes = 6, .files = 3});
  for (const char* line : {"line1\n", "line2\n", "line3\n", "line4\n", "5\n"}) {
    ASSERT_TRUE(journal.append(line));
  }
  EXPECT_EQ(lines_of(file("audit.jsonl")), (std::vector<std::string>{"5"}));
  EXPECT_EQ(lines_of(file("audit.1.jsonl")), (std::vector<std::string>{"line4"}));
  EXPECT_EQ(lines_of(file("audit.2.jsonl")), (std::vector<std::string>{"line3"}));
  EXPECT_FALSE(std::ifstream(file("audit.3.jsonl")));
}

TEST_F(JournalTest, FollowsAnotherProcessThatBeginsANewFile) {
  Journal ours(folder_, {.bytes = 6, .files = 3});
  Journal theirs(folder_, {.bytes = 6, .files = 3});
  ASSERT_TRUE(ours.append("o\n"));
  ASSERT_TRUE(theirs.append("their\n"));
  ASSERT_TRUE(ours.append("o2\n"));
  EXPECT_EQ(lines_of(file("audit.1.jsonl")), (std::vector<std::string>{"o", "their"}));
  EXPECT_EQ(lines_of(file("audit.jsonl")), (std::vector<std::string>{"o2"}));
}

TEST_F(JournalTest, RefusesAFileThatIsALink) {
  std::filesystem::create_directories(folder_);
  std::ofstream(scratch_.path() + "/precious") << "precious\n";
  std::filesystem::create_symlink(scratch_.path() + "/precious", file("audit.jsonl"));
  const auto appended = Journal(folder_).append("one\n");
  ASSERT_FALSE(appended);
  EXPECT_EQ(appended.error(), file("audit.jsonl") + ": Too many levels of symbolic links");
  EXPECT_EQ(lines_of(scratch_.path() + "/precious"), (std::vector<std::string>{"precious"}));
}

TEST_F(JournalTest, SaysThatADiskIsFullAndLaterGoesOnWithANewLine) {
  // A limit of the size of files fails as a full disk does: a part of the text is written.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  Journal journal(folder_);
  ASSERT_TRUE(journal.append("one\n"));
  const rlimit full{6, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto second = journal.append("second\n");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error(), file("audit.jsonl") + ": No space left on device");
  ASSERT_TRUE(journal.append("three\n"));
  EXPECT_EQ(lines_of(file("audit.jsonl")), (std::vector<std::string>{"one", "se", "three"}));
}

TEST_F(JournalTest, AuditWritesWhatWaitsBeforeItEnds) {
  {
    Audit audit{Journal(folder_)};
    audit.add(command(1));
    audit.add(command(2));
  }
  EXPECT_EQ(lines_of(file("audit.jsonl")).size(), 2u);
}

TEST_F(JournalTest, AuditCountsTheLinesForWhichThereIsNoRoom) {
  {
    Audit audit{Journal(folder_)};  // nobody calls flush(), so nothing is written meanwhile
    for (std::uint64_t n = 0; n < Audit::most_waiting + 5; ++n) audit.add(command(n + 1));
  }
  const auto lines = lines_of(file("audit.jsonl"));
  ASSERT_EQ(lines.size(), Audit::most_waiting + 1);
  EXPECT_NE(lines[0].find("\"event\":\"lines_lost\",\"count\":5"), std::string::npos) << lines[0];
}

TEST_F(JournalTest, AuditWithoutADiskSaysSoOnceAndCountsWhatItLost) {
  testing::internal::CaptureStderr();
  {
    Audit audit{Journal("/dev/null/gecos")};
    for (int n = 0; n < 3; ++n) {
      audit.add(command(1));
      audit.flush();
      std::this_thread::yield();
    }
  }
  const std::string said = testing::internal::GetCapturedStderr();
  const auto first = said.find("gecos error audit: the audit is not written: /dev/null/gecos/");
  EXPECT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("gecos error", first + 1), std::string::npos) << said;
}

TEST(AuditFolder, IsThatOfTheVariableElseOfTheUsersState) {
  ::setenv("GECOS_AUDIT_DIR", "/srv/audit", 1);
  EXPECT_EQ(default_folder(), "/srv/audit");
  ::unsetenv("GECOS_AUDIT_DIR");
  ::setenv("XDG_STATE_HOME", "/srv/state", 1);
  EXPECT_EQ(default_folder(), "/srv/state/gecos/audit");
  ::unsetenv("XDG_STATE_HOME");
  ::setenv("HOME", "/home/ann", 1);
  EXPECT_EQ(default_folder(), "/home/ann/.local/state/gecos/audit");
}

}  // namespace
}  // namespace gecos::audit
