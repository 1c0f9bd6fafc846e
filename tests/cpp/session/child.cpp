#include "child.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace probe {

std::string Child::Line::hear() {
  std::string word;
  char letter = 0;
  while (read(in_, &letter, 1) == 1) {
    if (letter == '\n') return word;
    word += letter;
  }
  throw std::runtime_error("the other process is gone after '" + word + "'");
}

void Child::Line::say(const std::string& word) {
  const std::string line = word + "\n";
  if (write(out_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    throw std::runtime_error("the other process is gone");
  }
}

Child::Child(const std::function<void(Line&)>& program) {
  if (pipe(to_child_) != 0 || pipe(from_child_) != 0) throw std::runtime_error("pipe failed");
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ == 0) {
    close(to_child_[1]);
    close(from_child_[0]);
    Line line(to_child_[0], from_child_[1]);
    try {
      program(line);
    } catch (const std::exception&) {
      std::_Exit(3);  // the test is over
    }
    std::exit(0);
  }
  close(to_child_[0]);
  close(from_child_[1]);
  line_ = Line(from_child_[0], to_child_[1]);
}

Child::~Child() {
  kill_at_once();
  close(to_child_[1]);
  close(from_child_[0]);
}

void Child::signal(int number) {
  if (pid_ <= 0) return;
  ::kill(pid_, number);
  if (number == SIGSTOP) ::waitpid(pid_, nullptr, WUNTRACED);  // all its threads stand
}

void Child::kill_at_once() {
  if (pid_ <= 0) return;
  signal(SIGKILL);
  wait();
}

int Child::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace probe
