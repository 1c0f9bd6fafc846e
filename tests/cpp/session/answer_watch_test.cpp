#include "gecos/session/client/answer_watch.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

class AnswerWatchTest : public ::testing::Test {
 protected:
  using Verdict = AnswerWatch::Verdict;
  Verdict judge(Duration after, bool open = true) {
    return watch.judge(open, heard, begin + after);
  }

  const TimePoint begin{100s};
  std::uint64_t heard = 0;
  AnswerWatch watch{1s, 3s, begin};
};

TEST_F(AnswerWatchTest, AsksNothingWhileNoCallIsOpen) {
  for (int second = 0; second < 60; ++second) {
    EXPECT_EQ(judge(second * 1s, false), Verdict::Fine);
  }
}

TEST_F(AnswerWatchTest, AsksOnceASecondWhatBecomesOfACall) {
  EXPECT_EQ(judge(999ms), Verdict::Fine);
  EXPECT_EQ(judge(1000ms), Verdict::Ask);
  EXPECT_EQ(judge(1999ms), Verdict::Fine);
  EXPECT_EQ(judge(2000ms), Verdict::Ask);
}

TEST_F(AnswerWatchTest, GivesUpAServerThatHasAnsweredNothing) {
  judge(0s, false);
  EXPECT_NE(judge(2999ms), Verdict::Mute);
  EXPECT_EQ(judge(3000ms), Verdict::Mute);
}

TEST_F(AnswerWatchTest, AnyAnswerIsAnAnswer) {
  for (int second = 1; second < 60; ++second) {
    ++heard;
    EXPECT_EQ(judge(second * 1s), Verdict::Ask) << "a call may be open for as long as it likes";
  }
}

TEST_F(AnswerWatchTest, SilenceBeforeTheFirstCallDoesNotCount) {
  judge(60s, false);
  EXPECT_EQ(judge(62s), Verdict::Ask);
  EXPECT_EQ(judge(63s), Verdict::Mute);
}

}  // namespace
}  // namespace gecos::session
