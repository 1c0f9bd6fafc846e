#include "gecos/broker/processes.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "child.hpp"

namespace gecos::broker {
namespace {

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
