#pragma once

#include <functional>
#include <stop_token>
#include <thread>

#include "gecos/base/clock.hpp"

namespace devices {

/// Calls `work` once every `period` on a separate thread, from the constructor to the destructor.
///
/// The cycles have absolute start times. A late cycle does not delay the following cycles, and
/// missed cycles are skipped.
class Periodic {
 public:
  /// `work` receives the time since the last cycle in s: `period`, or a multiple of `period` after
  /// missed cycles. `begin` is called once on the thread, before the first cycle.
  Periodic(
      gecos::Duration period, std::function<void(double seconds)> work,
      std::function<void()> begin = [] {});

 private:
  std::jthread thread_;
};

}  // namespace devices
