#include "gecos/base/file_thread.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace {

using gecos::FileThread;
using std::chrono::milliseconds;

/// A file whose reading takes until `answer` is called.
class SlowFile {
 public:
  SlowFile() {
    EXPECT_EQ(::pipe(begun_), 0);
    EXPECT_EQ(::pipe(answered_), 0);
  }
  void read() {
    pass(begun_);
    await(answered_);
  }
  void await_reading() { await(begun_); }
  void answer() { pass(answered_); }

 private:
  static void pass(int* pipe) { EXPECT_EQ(::write(pipe[1], "", 1), 1); }
  static void await(int* pipe) {
    char byte;
    EXPECT_EQ(::read(pipe[0], &byte, 1), 1);
  }

  int begun_[2];
  int answered_[2];
};

TEST(FileThread, AwaitEndsWhenTheFileSystemDoesNotAnswer) {
  SlowFile file;
  FileThread thread("test-files", [&] { file.read(); });
  const std::uint64_t first = thread.ask();
  file.await_reading();
  EXPECT_FALSE(thread.await(first, milliseconds(500)));

  const std::uint64_t next = thread.ask();
  const auto before = std::chrono::steady_clock::now();
  // The patience counts from the beginning of the first run.
  EXPECT_FALSE(thread.await(next, milliseconds(500)));
  EXPECT_LT(std::chrono::steady_clock::now() - before, milliseconds(450));

  file.answer();
  file.answer();
  EXPECT_TRUE(thread.await(next, std::chrono::seconds(10)));
}

TEST(FileThread, TimeInWhichTheProcessStandsStillDoesNotCount) {
  SlowFile file;
  int ended[2];  // the end of the child closes its end of this pipe
  ASSERT_EQ(::pipe(ended), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    FileThread thread("test-files", [&] { file.read(); });
    ::_exit(thread.await(thread.ask(), milliseconds(1000)) ? 0 : 1);
  }
  ::close(ended[1]);
  file.await_reading();
  ::kill(child, SIGSTOP);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, WUNTRACED), child);
  ASSERT_TRUE(WIFSTOPPED(status));
  std::this_thread::sleep_for(milliseconds(1200));  // the time that must not count
  ::kill(child, SIGCONT);
  pollfd end_of_child{ended[0], POLLIN, 0};
  EXPECT_EQ(::poll(&end_of_child, 1, 100), 0) << "the child does not wait any more";
  file.answer();
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  ::close(ended[0]);
}

}  // namespace
