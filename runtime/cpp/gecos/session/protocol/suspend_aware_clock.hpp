#pragma once

#include <algorithm>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// A clock for peer time-outs and leases. It does not advance while this process does not run,
/// because the process then reads no messages of its peers. Each `advance` adds the time since the
/// previous `advance`, but at most `longest_step`.
class SuspendAwareClock {
 public:
  SuspendAwareClock(TimePoint begin, Duration longest_step)
      : looked_(begin), now_(begin), longest_step_(longest_step) {}

  TimePoint now() const { return now_; }
  TimePoint advance(TimePoint now) {
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
