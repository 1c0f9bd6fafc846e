#include "gecos/base/log.hpp"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace gecos {
namespace {

class Log : public testing::Test {
 protected:
  void TearDown() override { set_log_level(LogLevel::Warning); }
};

TEST_F(Log, WritesOneLineWithLevelAndComponent) {
  testing::internal::CaptureStderr();
  log_warning("session", "lost RX90");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "gecos warning session: lost RX90\n");
}

TEST_F(Log, KeepsAMessageOnOneLine) {
  testing::internal::CaptureStderr();
  log_error("broker", "first\nsecond");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "gecos error broker: first second\n");
}

TEST_F(Log, SaysOnlyWhatWasAskedFor) {
  set_log_level(LogLevel::Error);
  EXPECT_TRUE(log_enabled(LogLevel::Error));
  EXPECT_FALSE(log_enabled(LogLevel::Warning));
  testing::internal::CaptureStderr();
  log_warning("session", "not shown");
  log_debug("session", "not shown");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  set_log_level(LogLevel::Debug);
  testing::internal::CaptureStderr();
  log_debug("session", "shown");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "gecos debug session: shown\n");
}

TEST_F(Log, KnowsItsLevelsByName) {
  EXPECT_EQ(parse_log_level("error"), LogLevel::Error);
  EXPECT_EQ(parse_log_level("warning"), LogLevel::Warning);
  EXPECT_EQ(parse_log_level("info"), LogLevel::Info);
  EXPECT_EQ(parse_log_level("debug"), LogLevel::Debug);
  EXPECT_EQ(parse_log_level("Debug"), std::nullopt);
  EXPECT_EQ(parse_log_level(""), std::nullopt);
}

TEST_F(Log, LinesOfSeveralThreadsDoNotMix) {
  const std::vector<std::string> words{std::string(200, 'a'), std::string(200, 'b'),
                                       std::string(200, 'c')};
  testing::internal::CaptureStderr();
  std::vector<std::thread> threads;
  for (const std::string& word : words) {
    threads.emplace_back([&word] {
      for (int i = 0; i < 200; ++i) log_error("test", word);
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::istringstream lines(testing::internal::GetCapturedStderr());
  std::set<std::string> seen;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) seen.insert(line);
  EXPECT_EQ(count, 600);
  EXPECT_EQ(seen,
            (std::set<std::string>{"gecos error test: " + words[0], "gecos error test: " + words[1],
                                   "gecos error test: " + words[2]}));
}

}  // namespace
}  // namespace gecos
