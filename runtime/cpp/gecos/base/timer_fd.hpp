#pragma once

#include "gecos/base/clock.hpp"
#include "gecos/base/descriptor.hpp"

namespace gecos {

/// A timerfd, which becomes readable once after the time for which it was set. Any thread may set
/// it.
class TimerFd {
 public:
  /// Throws std::system_error when the process cannot open another file descriptor.
  TimerFd();
  int descriptor() const { return fd_.get(); }
  /// Makes the descriptor readable when `after` has passed; `after` must be positive. Replaces an
  /// earlier time that has not passed yet.
  void set(Duration after) const;
  /// Makes the descriptor unreadable again.
  void drain() const;

 private:
  Descriptor fd_;
};

}  // namespace gecos
