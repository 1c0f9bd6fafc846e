#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace gecos::broker {

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
  /// Lets the process end. Does not wait for its end, so the process stays a zombie until then.
  void end() {
    if (line_ >= 0) close(line_);
    line_ = -1;
  }

 private:
  pid_t pid_ = 0;
  int line_ = -1;
};

}  // namespace gecos::broker
