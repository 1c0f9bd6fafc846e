#pragma once

#include <functional>
#include <stop_token>
#include <thread>

#include "devices/support/lab_clock.hpp"
#include "gecos/base/clock.hpp"

namespace devices {

/// Calls `work` once every `period` on a separate thread, from the constructor to the destructor.
///
/// The cycles have absolute start times. CycleTimer describes what happens to late cycles.
class Periodic {
 public:
  /// `work` receives the time since the last cycle in s: `period`, or a multiple of `period` after
  /// missed cycles.
  Periodic(gecos::Duration period, std::function<void(double seconds)> work);
  /// `period` and the time that `work` receives are simulated time, as `clock` counts it. This
  /// object tells `clock` which speed the cycles have reached. Calls `begin` once on the same
  /// thread as `work`, before the first cycle.
  Periodic(
      LabClock& clock, gecos::Duration period, std::function<void(double seconds)> work,
      std::function<void()> begin = [] {});

 private:
  std::jthread thread_;
};

}  // namespace devices
