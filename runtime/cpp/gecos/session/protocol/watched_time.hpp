#pragma once

#include <algorithm>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Time by which peers are judged for their silence. It stands while the judge does not look: who
/// was himself kept from running has not read what the others said meanwhile, and must not count it
/// as their silence. Each look adds what passed since the last one, at most `longest_step`.
class WatchedTime {
 public:
  WatchedTime(TimePoint begin, Duration longest_step)
      : looked_(begin), now_(begin), longest_step_(longest_step) {}

  TimePoint now() const { return now_; }
  TimePoint look(TimePoint now) {
    now_ += std::clamp(now - looked_, Duration::zero(), longest_step_);
    looked_ = now;
    return now_;
  }

 private:
  TimePoint looked_;
  TimePoint now_;
  Duration longest_step_;
};

}  // namespace gecos::session
