// What a server writes into the audit about its clients, over every medium.
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <future>

#include "../media/scratch_directory.hpp"
#include "../session/over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::State;

/// Tells GECOS_AUDIT_DIR before the servers of the bench exist.
struct OwnFolder {
  OwnFolder() { ::setenv("GECOS_AUDIT_DIR", directory.path().c_str(), 1); }
  const gecos::media::ScratchDirectory directory;
};

class AuditTrail : public OwnFolder, public probe::OverMedia {
 protected:
  void TearDown() override { gecos::set_log_level(gecos::LogLevel::Warning); }

  /// Ends the server, which writes all that it knows, and returns the lines about PROBE.
  std::vector<std::string> lines() {
    server_.reset();
    std::ifstream file(directory.path() + "/audit.jsonl");
    std::vector<std::string> found;
    for (std::string line; std::getline(file, line);) {
      if (line.find("\"object\":\"PROBE\"") != std::string::npos) found.push_back(line);
    }
    return found;
  }
  static std::size_t count(const std::vector<std::string>& lines, const std::string& part) {
    return static_cast<std::size_t>(std::ranges::count_if(
        lines, [&](const auto& line) { return line.find(part) != std::string::npos; }));
  }
  static std::string number_in(const std::string& text) {
    const auto at = text.find("(request ");
    return at == std::string::npos ? "" : text.substr(at + 9, text.find(')', at) - at - 9);
  }
};
PROBE_OVER_MEDIA(AuditTrail);

TEST_P(AuditTrail, TellsWhoHeldTheStatusAndWhichCommandsMovedTheObject) {
  std::string moved;
  {
    const auto probe = connect(lab_);
    const auto lease = gecos::actor(probe);
    ASSERT_TRUE(lease) << lease.error();
    const auto move = probe.move(1);
    servant_.await_moves(1);
    moved = to_string(move.id());
    EXPECT_TRUE(gecos::stop(probe).get());
    EXPECT_EQ(move.wait(), State::CommandFailed);
    EXPECT_TRUE(probe.read().get());
  }
  const auto told = lines();
  const std::string me = "\"program\":\"audit_trail_test\",\"pid\":" + std::to_string(getpid());
  EXPECT_EQ(count(told, me), told.size()) << "each line says who";
  EXPECT_EQ(count(told, "\"event\":\"connected\""), 1u);
  EXPECT_EQ(count(told, "\"event\":\"status_granted\""), 1u);
  EXPECT_EQ(count(told, "\"event\":\"command_begins\",\"object\":\"PROBE\",\"request\":\"" + moved),
            1u);
  EXPECT_EQ(
      count(told, "\"request\":\"" + moved + "\",\"operation\":\"move\",\"outcome\":\"STOPPED"),
      1u);
  EXPECT_EQ(count(told, "\"event\":\"stopped\""), 1u);
  EXPECT_EQ(count(told, "\"event\":\"disconnected\""), 1u);
  EXPECT_EQ(count(told, "\"operation\":\"read\""), 0u) << "readings are not recorded";
}

TEST_P(AuditTrail, ExplainsARefusalByTheNumberInItsText) {
  const auto probe = connect(lab_);
  const auto denied = probe.set(1);
  const auto end = denied.get();
  ASSERT_FALSE(end);
  EXPECT_EQ(number_in(end.error().text), to_string(denied.id())) << end.error();

  const auto moves = probe.move(1);
  EXPECT_FALSE(moves.get());

  const auto other = connect(second_lab_);
  const auto lease = gecos::actor(other);
  const auto refused = gecos::actor(probe);
  ASSERT_FALSE(refused);
  const std::string number = number_in(testing::PrintToString(refused.error()));
  EXPECT_NE(number, "") << refused.error();

  const auto told = lines();
  EXPECT_EQ(count(told, "\"request\":\"" + to_string(denied.id()) +
                            "\",\"operation\":\"set\",\"outcome\":\"DENIED\""),
            1u);
  EXPECT_EQ(count(told, "\"request\":\"" + to_string(moves.id()) +
                            "\",\"operation\":\"move\",\"outcome\":\"DENIED\""),
            1u)
      << "another operation does not share a line, even within a second";
  EXPECT_EQ(
      count(told, "\"event\":\"status_refused\",\"object\":\"PROBE\",\"request\":\"" + number), 1u);
}

TEST_P(AuditTrail, TellsWhoDeniedARequestAndWhoBrokeTheStatusAndWhy) {
  const auto holder = connect(lab_);
  const auto lease = gecos::actor(holder);
  ASSERT_TRUE(lease) << lease.error();
  const auto other = connect(second_lab_);
  auto asking =
      std::async(std::launch::async, [&] { return gecos::actor(other, {.timeout = 60s}); });
  const auto waiting = gecos::requests(holder, 0, 60s).get();
  ASSERT_TRUE(waiting) << waiting.error();
  ASSERT_TRUE(gecos::deny(holder, waiting->front().id, "a part is in the gripper").get());
  const auto denied = asking.get();
  ASSERT_FALSE(denied);
  const std::string number = number_in(denied.error().failure.text);
  EXPECT_NE(number, "") << denied.error();
  const auto stranger = gecos::deny(other, 1).get();
  ASSERT_FALSE(stranger);
  EXPECT_NE(number_in(stranger.error().text), "") << stranger.error();
  const auto broken = gecos::break_status(other, "its program hangs").get();
  ASSERT_TRUE(broken) << broken.error();

  const auto told = lines();
  const auto refused = std::ranges::find_if(told, [&](const auto& line) {
    return line.find("\"event\":\"status_refused\",\"object\":\"PROBE\",\"request\":\"" + number) !=
           std::string::npos;
  });
  ASSERT_NE(refused, told.end());
  EXPECT_NE(refused->find(": a part is in the gripper\""), std::string::npos) << *refused;
  EXPECT_EQ(count(told, "\"request\":\"" + number_in(stranger.error().text) +
                            "\",\"operation\":\"deny\",\"outcome\":\"FAULT\""),
            1u);
  const auto lost = std::ranges::find_if(told, [&](const auto& line) {
    return line.find("\"event\":\"status_lost\"") != std::string::npos;
  });
  ASSERT_NE(lost, told.end());
  EXPECT_NE(lost->find("an administrator, "), std::string::npos) << *lost;
  EXPECT_NE(lost->find(" broke it: its program hangs\""), std::string::npos) << *lost;
}

TEST_P(AuditTrail, TellsThatTooManyPasswordsWereWrong) {
  const auto holder = connect(lab_);
  const auto lease = gecos::actor(holder, "sesame");
  ASSERT_TRUE(lease) << lease.error();
  const auto other = connect(second_lab_);
  for (int guess = 0; guess < 5; ++guess) EXPECT_FALSE(gecos::actor(other, "open"));
  gecos::Lab third_lab(probe::patient());
  const auto refused = gecos::actor(connect(third_lab), "sesame");
  ASSERT_FALSE(refused);
  const std::string number = number_in(refused.error().failure.text);
  EXPECT_NE(number, "") << refused.error();
  const auto told = lines();
  const auto line = std::ranges::find_if(told, [&](const auto& one) {
    return one.find(number) != std::string::npos && one.find("status_refused") != std::string::npos;
  });
  ASSERT_NE(line, told.end());
  EXPECT_NE(line->find("5 wrong passwords within a minute"), std::string::npos) << *line;
}

TEST_P(AuditTrail, CountsCommandsThatAreRepeatedWithinASecond) {
  {
    const auto probe = connect(lab_);
    const auto lease = gecos::actor(probe);
    ASSERT_TRUE(lease) << lease.error();
    for (int value = 0; value < 50; ++value) ASSERT_TRUE(probe.set(value).get());
  }
  std::uint64_t commands = 0;
  std::size_t written = 0;
  for (const auto& line : lines()) {
    if (line.find("\"operation\":\"set\"") == std::string::npos) continue;
    const auto at = line.find("\"count\":");
    commands += at == std::string::npos ? 1 : std::stoul(line.substr(at + 8));
    ++written;
  }
  EXPECT_EQ(commands, 50u) << "each is in one line";
  EXPECT_LT(written, 50u);
}

TEST_P(AuditTrail, ContainsNoPasswordNorDoesTheLog) {
  gecos::set_log_level(gecos::LogLevel::Debug);
  testing::internal::CaptureStderr();
  {
    const auto probe = connect(lab_);
    const auto other = connect(second_lab_);
    const auto lease = gecos::actor(probe, "s3cret-of-ann");
    ASSERT_TRUE(lease) << lease.error();
    EXPECT_FALSE(gecos::actor(other, "s3cret-guess"));
    const auto shared = gecos::actor(other, "s3cret-of-ann");
    ASSERT_TRUE(shared) << shared.error();
    EXPECT_TRUE(gecos::take_over(other).get());
    EXPECT_TRUE(gecos::give_back(other).get());
  }
  const auto told = lines();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(count(told, "s3cret"), 0u);
  EXPECT_EQ(log.find("s3cret"), std::string::npos) << log;
  EXPECT_EQ(count(told, "\"event\":\"status_granted\""), 2u);
  EXPECT_EQ(count(told, "\"event\":\"taken_over\""), 1u);
  EXPECT_EQ(count(told, "\"event\":\"given_back\""), 1u);
}

}  // namespace
