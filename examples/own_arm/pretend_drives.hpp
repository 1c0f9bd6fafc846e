// Stands for the library of the maker of the drives: six joints that are at once where they are
// told to be.
#pragma once

#include <unistd.h>

#include <array>
#include <fstream>
#include <iomanip>

/// The drives append each new set point to the file "set_points.txt" of the working folder. They
/// have a fault as soon as there is a file "emergency_stop".
class PretendDrives {
 public:
  using Joints = std::array<double, 6>;  // rad

  explicit PretendDrives(const Joints& start) : joints_(start) {}

  /// Fails while the drives have a fault.
  bool turn_on() { return on_ = fault()[0] == '\0'; }
  void turn_off() { on_ = false; }
  bool on() { return on_ && fault()[0] == '\0'; }
  /// Returns the text of the fault; an empty text if there is none. A fault stays until it is
  /// cleared.
  const char* fault() {
    if (access("emergency_stop", F_OK) == 0) faulty_ = true;
    return faulty_ ? "the emergency stop is pressed" : "";
  }
  void clear_fault() {
    on_ = false;
    faulty_ = false;
  }

  const Joints& joints() const { return joints_; }
  void go_to(const Joints& set_point) {
    if (!on() || set_point == joints_) return;
    joints_ = set_point;
    for (const double joint : joints_) set_points_ << std::setprecision(12) << joint << ' ';
    set_points_ << std::endl;
  }

 private:
  Joints joints_;
  bool on_ = false;
  bool faulty_ = false;
  std::ofstream set_points_{"set_points.txt"};
};
