#include "gecos/base/file_thread.hpp"

#include <gtest/gtest.h>
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
  EXPECT_FALSE(
      thread.await(next, milliseconds(500)));  // counts from the beginning of the first run
  EXPECT_LT(std::chrono::steady_clock::now() - before, milliseconds(450));

  file.answer();
  file.answer();
  EXPECT_TRUE(thread.await(next, std::chrono::seconds(10)));
}

TEST(FileThread, TimeInWhichTheProcessStandsStillDoesNotCount) {
  SlowFile file;
  const pid_t child = ::fork();
  if (child == 0) {
    FileThread thread("test-files", [&] { file.read(); });
    ::_exit(thread.await(thread.ask(), milliseconds(1000)) ? 0 : 1);
  }
  file.await_reading();
  std::this_thread::sleep_for(milliseconds(100));  // so that the pause comes during `await`
  ::kill(child, SIGSTOP);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, WUNTRACED), child);
  ASSERT_TRUE(WIFSTOPPED(status));
  std::this_thread::sleep_for(milliseconds(1200));  // the time that must not count
  ::kill(child, SIGCONT);
  std::this_thread::sleep_for(milliseconds(100));  // the file system answers a little later
  file.answer();
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
