#include "gecos/base/log.hpp"

#include <gtest/gtest.h>
#include <limits.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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

/// stderr is a pipe that nobody reads, until it is asked what came out of it.
class UnreadStderr {
 public:
  UnreadStderr() : before_(::dup(STDERR_FILENO)) {
    EXPECT_EQ(::pipe(ends_.data()), 0);
    ::dup2(ends_[1], STDERR_FILENO);
  }
  ~UnreadStderr() {
    ::dup2(before_, STDERR_FILENO);
    for (const int end : {before_, ends_[0], ends_[1]}) ::close(end);
  }
  std::string read() {
    std::string text(1 << 20, '\0');
    const ssize_t size = ::read(ends_[0], text.data(), text.size());
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }

 private:
  const int before_;
  std::array<int, 2> ends_{};
};

TEST_F(Log, NobodyWaitsForAStderrThatIsNotReadAndTheLossIsTold) {
  UnreadStderr unread;
  for (int i = 0; i < 10'000; ++i) log_warning("test", "one of very many");
  const std::string before = unread.read();
  const auto written = std::count(before.begin(), before.end(), '\n');
  EXPECT_LT(written, 10'000);
  EXPECT_EQ(before.find("were lost"), std::string::npos);
  log_warning("test", "read again");
  EXPECT_EQ(unread.read(), "gecos warning log: " + std::to_string(10'000 - written) +
                               " lines were lost because nobody read stderr\n"
                               "gecos warning test: read again\n");
}

TEST_F(Log, ALineThatAPipeDoesNotTakeAtOnceLosesItsMiddle) {
  UnreadStderr unread;
  log_warning("test", "begin " + std::string(100'000, 'x') + " end");
  const std::string line = unread.read();
  EXPECT_EQ(line.size(), std::size_t{PIPE_BUF});
  EXPECT_EQ(line.rfind("gecos warning test: begin xxx", 0), 0u);
  EXPECT_NE(line.find("x … x"), std::string::npos);
  EXPECT_TRUE(line.ends_with("xxx end\n"));
}

TEST_F(Log, AShortenedLineKeepsWholeCharacters) {
  for (const std::string shift : {"", "s", "sh", "shi"}) {
    UnreadStderr unread;
    std::string text = shift;
    for (int i = 0; i < 30'000; ++i) text += "€";  // three bytes
    log_warning("test", text);
    std::string line = unread.read();
    EXPECT_LE(line.size(), std::size_t{PIPE_BUF});
    EXPECT_GE(line.size(), std::size_t{PIPE_BUF} - 4);
    for (std::size_t at; (at = line.find("€")) != std::string::npos;) line.erase(at, 3);
    EXPECT_EQ(line, "gecos warning test: " + shift + " … \n");
  }
}

}  // namespace
}  // namespace gecos
