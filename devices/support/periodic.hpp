#pragma once

#include <functional>
#include <stop_token>
#include <thread>

#include "gecos/base/clock.hpp"

namespace devices {

/// Calls `work` every `period` on a thread of its own, from construction to destruction.
///
/// Cycles have absolute times: a late cycle does not shift the following ones, and missed cycles
/// are skipped, not caught up.
class Periodic {
 public:
  /// `work` gets the time since the last call, in s: `period`, or a multiple after missed cycles.
  Periodic(gecos::Duration period, std::function<void(double seconds)> work);

 private:
  std::jthread thread_;
};

}  // namespace devices
