#pragma once

namespace gecos::session {

/// An eventfd: rung by any thread, slept on by poll.
class Wakeup {
 public:
  Wakeup();  ///< throws std::system_error when the process has no descriptor left
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  int descriptor() const { return descriptor_; }
  void ring();
  void quiet();  ///< until rung again

 private:
  int descriptor_;
};

}  // namespace gecos::session
