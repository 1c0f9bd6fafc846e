#include "gecos/session/process/termination_signals.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

namespace gecos::session {
namespace {

bool has_come(const TerminationSignals& asked) {
  pollfd waiting{asked.descriptor(), POLLIN, 0};
  return poll(&waiting, 1, 0) == 1;
}

bool handled(int signal) {
  struct sigaction now {};
  sigaction(signal, nullptr, &now);
  return now.sa_handler != SIG_DFL && now.sa_handler != SIG_IGN;
}

}  // namespace

TEST(TerminationSignals, IsSeenWhicheverThreadGetsTheSignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    ::signal(signal, SIG_DFL);  // `nohup … &` would have SIGINT ignored
    const TerminationSignals asked;
    EXPECT_FALSE(has_come(asked)) << "the signal of an earlier run";
    std::thread([signal] { pthread_kill(pthread_self(), signal); }).join();
    EXPECT_TRUE(has_come(asked));
  }
}

TEST(TerminationSignals, IsSeenByAllThatWait) {
  const TerminationSignals one;
  const TerminationSignals other;
  raise(SIGTERM);
  EXPECT_TRUE(has_come(one));
  EXPECT_TRUE(has_come(other));
}

TEST(TerminationSignals, EndsTheProgramAgainAsSoonAsNobodyWaits) {
  {
    const TerminationSignals one;
    const TerminationSignals other;
    EXPECT_TRUE(handled(SIGTERM));
  }
  EXPECT_FALSE(handled(SIGTERM));
  EXPECT_FALSE(handled(SIGINT));
}

TEST(TerminationSignals, LeavesAnIgnoredSignalIgnored) {
  const auto before = signal(SIGINT, SIG_IGN);
  {
    const TerminationSignals asked;
    EXPECT_FALSE(handled(SIGINT));
    EXPECT_TRUE(handled(SIGTERM));
  }
  signal(SIGINT, before);
}

TEST(TerminationSignals, OfAForkedChildIsNotThatOfItsParent) {
  const TerminationSignals asked;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    raise(SIGTERM);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the child outlived its SIGTERM";
  EXPECT_FALSE(has_come(asked));
}

TEST(TerminationSignals, AForkedChildMayWaitForSignalsOfItsOwn) {
  const TerminationSignals asked;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    int wrong = 0;
    {
      const TerminationSignals own;
      raise(SIGTERM);
      if (!has_come(own)) wrong = 1;
    }
    if (handled(SIGTERM)) wrong |= 2;
    _exit(wrong);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_FALSE(has_come(asked)) << "the signal was for the child";
  EXPECT_TRUE(handled(SIGTERM));
}

}  // namespace gecos::session
