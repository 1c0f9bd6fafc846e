#pragma once

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <stdexcept>

namespace gecos::media {

/// A forked process that runs `body` and says when it is ready. Killed with the test at the latest.
class ChildProcess {
 public:
  using Body = std::function<void(const std::function<void()>& say_ready)>;

  explicit ChildProcess(const Body& body) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      ::close(ends[0]);
      body([&] { [[maybe_unused]] const auto n = ::write(ends[1], "r", 1); });
      ::_exit(0);
    }
    ::close(ends[1]);
    ready_ = ends[0];
  }
  ~ChildProcess() {
    kill();
    ::close(ready_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// False: it ended before it was ready.
  bool wait_ready() const {
    char c = 0;
    return ::read(ready_, &c, 1) == 1;
  }
  pid_t pid() const { return pid_; }
  void kill(int signal = SIGKILL) {
    if (pid_ <= 0) return;
    ::kill(pid_, signal);
    if (signal == SIGKILL) wait();
  }
  /// Its exit status, or -1 when a signal ended it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  int ready_ = -1;
};

}  // namespace gecos::media
