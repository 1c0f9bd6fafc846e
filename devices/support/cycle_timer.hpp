#pragma once

#include "gecos/base/clock.hpp"

namespace devices {

/// Decides when the cycles of a device begin. The caller passes the current time. There are two
/// rules for late cycles:
///
/// In real time, at speed 1, a late cycle does not delay the following cycles: missed cycles are
/// skipped, and the next cycle simulates their time too. At any other speed no cycle is skipped. A
/// device that is late begins its next cycles without a pause until it has caught up. If it is late
/// by `most_behind`, simulated time passes more slowly than requested.
class CycleTimer {
 public:
  static constexpr gecos::Duration most_behind = std::chrono::milliseconds(20);
  /// The time over which `reached` takes the mean.
  static constexpr gecos::Duration window = std::chrono::milliseconds(200);

  /// `period` is the simulated time from one cycle to the next, `speed` the number of simulated
  /// seconds that are to pass in a second of real time.
  CycleTimer(gecos::Duration period, double speed, gecos::TimePoint start);

  struct Cycle {
    gecos::TimePoint begins;
    double seconds = 0;  ///< simulated time since the last cycle
  };
  /// Returns when the next cycle begins, and the simulated time that it covers. Does not wait.
  /// Must be called once for each cycle.
  Cycle next(gecos::TimePoint now);

  /// Returns how many simulated seconds passed in a second of real time, as the mean over the last
  /// `window`.
  double reached() const { return reached_; }

 private:
  void measure(gecos::TimePoint now);

  const gecos::Duration period_;
  const double speed_;
  gecos::TimePoint last_;
  gecos::TimePoint measured_since_;
  double simulated_ = 0;  // s, since measured_since_
  double reached_;
  bool first_window_ = true;
};

}  // namespace devices
