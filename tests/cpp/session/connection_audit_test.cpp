// How much a user who is refused again and again adds to the audit of a server.
#include "gecos/session/server/connection_audit.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "../media/scratch_directory.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

std::int64_t fake_now = 0;

class RefusedConnections : public ::testing::Test {
 protected:
  void SetUp() override { fake_now = 1'795'820'462'000; }

  std::string refuse(const std::string& user, const std::string& why = "PROBE refuses you: no") {
    return connections_.refused("refused", "PROBE", {false, false, {user, "desk"}, why});
  }
  /// Lets the time pass in which the user connects every 200 ms.
  void keep_refusing(const std::string& user, std::chrono::minutes time) {
    const std::int64_t end = fake_now + std::chrono::milliseconds(time).count();
    for (; fake_now < end; fake_now += 200) {
      refuse(user);
      connections_.on_tick();
    }
  }
  /// Ends the audit, and returns its lines about `user`.
  std::vector<std::string> lines_about(const std::string& user) {
    auto lines = all_lines();
    std::erase_if(lines, [&](const std::string& line) {
      return line.find("\"user\":\"" + user + "\"") == std::string::npos;
    });
    return lines;
  }
  std::vector<std::string> all_lines() {
    connections_.end();
    audit_->end();
    std::ifstream file(folder_.path() + "/audit.jsonl");
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

  const media::ScratchDirectory folder_;
  const std::shared_ptr<audit::Audit> audit_ =
      std::make_shared<audit::Audit>(audit::Journal(folder_.path()));
  ConnectionAudit connections_{audit_, [] { return fake_now; }};
};

TEST_F(RefusedConnections, OfOneUserAddALineAMinuteHoweverOftenTheUserConnects) {
  keep_refusing("ben", 60min);
  const auto lines = lines_about("ben");
  EXPECT_LE(lines.size(), 1u + 6u + 60u);
  EXPECT_GE(lines.size(), 60u);
}

TEST_F(RefusedConnections, OfOneUserDoNotHideThoseOfAnotherOrOfAnotherReason) {
  keep_refusing("ben", 1min);
  refuse("ann");
  refuse("ann", "PROBE refuses you: another reason");
  refuse("ann", "PROBE refuses you: another reason since 12 s");
  refuse("ann", "PROBE refuses you: another reason since 13 s");
  EXPECT_EQ(lines_about("ann").size(), 4u) << "the last two differ by their numbers alone";
}

TEST_F(RefusedConnections, OfTwoUsersHaveNumbersOfWhichALineThatCountsTellsApart) {
  const auto user_part = [](const std::string& text) {
    const auto at = text.find('-', text.find("(request ")) + 1;
    return text.substr(at, text.find('-', at) - at);
  };
  const std::string first = refuse("ben");
  const std::string other = refuse("ann");
  const std::string second = refuse("ben");
  EXPECT_NE(first, second);
  EXPECT_EQ(user_part(first), user_part(second));
  EXPECT_NE(user_part(first), user_part(other));
}

TEST_F(RefusedConnections, ThatWaitToBeCountedAreWrittenAtTheEnd) {
  refuse("ben");
  refuse("ben");
  refuse("ben");
  const auto lines = lines_about("ben");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[1].find("\"count\":2"), std::string::npos) << lines[1];
}

TEST_F(RefusedConnections, OfManyUsersShareLinesWhenThereAreTooMany) {
  const std::int64_t end = fake_now + std::chrono::milliseconds(1h).count();
  int user = 0;
  for (; fake_now < end; fake_now += 50) {
    refuse("user" + std::to_string(user++));
    if (user % 20 == 0) connections_.on_tick();
  }
  refuse("ben");
  EXPECT_EQ(lines_about("ben").size(), 0u) << "only counted";
  const auto counted = lines_about("several users");
  EXPECT_LE(counted.size(), 6u + 60u);
  EXPECT_GE(counted.size(), 60u);
  for (const auto& line : counted) {
    EXPECT_EQ(line.find("\"object\""), std::string::npos) << line;
    EXPECT_EQ(line.find("\"why\""), std::string::npos) << line;
  }
  EXPECT_LE(all_lines().size(), audit::SharedLines::most_kinds + 1u + 6u + 60u);
}

TEST_F(RefusedConnections, OfOneUserAreToldApartAgainWhenThereAreFewForAMinute) {
  for (int user = 0; user < 1000; ++user) refuse("user" + std::to_string(user));
  const std::int64_t end = fake_now + std::chrono::milliseconds(3min).count();
  for (; fake_now < end; fake_now += 1000) connections_.on_tick();
  refuse("ben");
  EXPECT_EQ(lines_about("ben").size(), 1u);
}

TEST_F(RefusedConnections, ThatAreCountedForSeveralUsersHaveNumbersOfTheirLine) {
  const auto part = [](const std::string& text) {
    const auto at = text.find('-', text.find("(request ")) + 1;
    return text.substr(at, text.find('-', at) - at);
  };
  for (int user = 0; user < 1000; ++user) refuse("user" + std::to_string(user));
  const std::string number = "-" + part(refuse("ann")) + "-";
  EXPECT_EQ(number, "-" + part(refuse("ben")) + "-");
  const auto lines = lines_about("several users");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find(number), std::string::npos) << lines[0];
}

}  // namespace
}  // namespace gecos::session
