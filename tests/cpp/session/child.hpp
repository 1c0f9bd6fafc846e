// Programs of their own for tests about dying. They are forked before this process has threads,
// wait until they are told to go, and say line by line what happens in them.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>

namespace probe {

class Child {
 public:
  /// What a child has to speak with its test.
  class Line {
   public:
    Line(int in, int out) : in_(in), out_(out) {}
    /// Throws when the other side is gone.
    std::string hear();
    void say(const std::string& word);

   private:
    int in_;
    int out_;
  };

  /// Runs `program` in a process of its own; it leaves by exit() when the program returns.
  explicit Child(const std::function<void(Line&)>& program);
  ~Child();  ///< kills it, if that was not done before
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  Line& line() { return line_; }
  /// Returns from SIGSTOP when nothing runs there any more.
  void signal(int number);
  /// kill -9
  void kill_at_once();
  /// Waits until it has left by itself; gives its exit status.
  int wait();

 private:
  pid_t pid_ = -1;
  int to_child_[2];
  int from_child_[2];
  Line line_{-1, -1};
};

}  // namespace probe
