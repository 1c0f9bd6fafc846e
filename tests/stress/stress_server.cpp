// Serves a Workbench until it is ended or killed, and notes when a command starts and finishes.

#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

#include "gecos/gecos.hpp"
#include "gecos/session/process/termination_signals.hpp"
#include "record.hpp"
#include "setting.hpp"
#include "workbench.hpp"

namespace {

/// What the first server of a process makes for all that follow: how SIGTERM reaches them.
void make_what_stays() {
  gecos::Lab lab;
  gecos::Server server(lab);
  server.shut_down();
  server.run();
}

/// A copy of this process that outlives it and has all its descriptors but 0 to 2, so that the
/// output ends with this process: made behind the back of pthread_atfork, as a library might. It is
/// found in the process group of this one, which is alone in it, and so ends with who started it.
void leave_a_child() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const long child = syscall(SYS_clone, SIGCHLD, nullptr, nullptr, nullptr, nullptr);
  if (child == 0) {
    for (const int standard : {0, 1, 2}) ::close(standard);
    alarm(600);  // it is killed before, unless the test itself was
    for (;;) pause();
  }
}

}  // namespace

int main(int count, char** words) {
  const stress::Setting setting(
      count, words,
      {{"name", "BENCH"}, {"record", ""}, {"medium", "shm"}, {"faults", ""}, {"child", "no"}});
  const stress::Record record(setting.text("record"));
  make_what_stays();
  const stress::Balance balance;
  {
    gecos::Lab lab(setting.lab());
    stress::RecordedBench workbench(record);
    gecos::Server server(lab);
    const auto added = server.add(setting.text("name"), workbench, stress::over(setting.medium()));
    if (!added) {
      std::fprintf(stderr, "%s\n", added.error().text.c_str());
      return 1;
    }
    if (setting.text("child") == "yes") leave_a_child();
    const gecos::session::TerminationSignals from_here_on;  // also before run() takes the signals
    record.note("serve " + std::to_string(getpid()));
    std::puts("ready");
    std::fflush(stdout);
    server.run();
  }
  balance.close();
  record.note("done");
}
