// The clock of a simulated laboratory. Its speed says how much simulated time passes in a second of
// real time.
#pragma once

#include <atomic>

namespace devices {

/// The clock of one device. Only simulated devices may have a speed other than 1, which is real
/// time. Time-outs of the communication, such as leases and watchdogs, are real time at any speed.
/// Thread-safe.
class LabClock {
 public:
  /// At a lower speed than `slowest`, readers would consider the samples of a control loop as lost.
  /// A higher speed than `fastest` would have no effect, because already at `fastest` each cycle
  /// begins when the previous one ends.
  static constexpr double slowest = 0.1, fastest = 100'000;

  /// `speed` is the number of simulated seconds that are to pass in a second of real time. @pre
  /// `speed` is from `slowest` to `fastest`.
  explicit LabClock(double speed = 1) : speed_(speed), reached_(speed) {}

  double speed() const { return speed_; }
  bool real_time() const { return speed_ == 1; }
  /// Returns the speed that the device has recently reached. This speed is below `speed()` if the
  /// machine is too slow.
  double reached() const { return reached_.load(); }
  void set_reached(double speed) { reached_.store(speed); }

 private:
  const double speed_;
  std::atomic<double> reached_;  // orders no other memory
};

}  // namespace devices
