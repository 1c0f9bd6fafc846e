#include "gecos/broker/processes.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gecos::broker {
namespace {

/// A process that waits until it is told to end.
class Child {
 public:
  Child() {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    pid_ = fork();
    if (pid_ == 0) {
      close(ends[1]);
      char none = 0;
      _exit(read(ends[0], &none, 1) == 0 ? 0 : 1);
    }
    close(ends[0]);
    line_ = ends[1];
  }
  ~Child() {
    end();
    waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  pid_t pid() const { return pid_; }
  /// It has nobody yet who waits for it.
  void end() {
    if (line_ >= 0) close(line_);
    line_ = -1;
  }

 private:
  pid_t pid_ = 0;
  int line_ = -1;
};

TEST(Processes, ReportTheEndOfOneThatTheyWatchOnce) {
  Processes processes;
  Child child;
  ASSERT_TRUE(processes.watch(child.pid()));
  ASSERT_TRUE(processes.watch(child.pid()));
  ASSERT_TRUE(processes.watch(getpid()));
  EXPECT_TRUE(processes.take_ended().empty());
  child.end();
  pollfd ended{processes.descriptor(), POLLIN, 0};
  ASSERT_EQ(poll(&ended, 1, 10'000), 1);
  EXPECT_EQ(processes.take_ended(), std::vector<std::int32_t>{child.pid()});
  EXPECT_TRUE(processes.take_ended().empty());
  EXPECT_EQ(processes.watched(), std::vector<std::int32_t>{getpid()});
}

TEST(Processes, DoNotWatchOneThatIsNotThere) {
  Processes processes;
  pid_t gone = 0;
  {
    const Child child;
    gone = child.pid();
  }
  EXPECT_FALSE(processes.watch(gone));
  EXPECT_FALSE(processes.watch(0));
  EXPECT_FALSE(processes.watch(-1));
  EXPECT_TRUE(processes.watched().empty());
}

TEST(Processes, ReportNothingOfOneThatTheyForgot) {
  Processes processes;
  Child child;
  ASSERT_TRUE(processes.watch(child.pid()));
  processes.forget(child.pid());
  child.end();
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child.pid()), nullptr, WEXITED | WNOWAIT), 0);
  EXPECT_TRUE(processes.take_ended().empty());
}

}  // namespace
}  // namespace gecos::broker
