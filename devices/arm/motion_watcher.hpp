#pragma once

#include <cstdint>

namespace devices {

/// The interface through which a running motion reports its progress to its caller, and asks
/// whether it must end. The arm calls these functions about every 5 ms, on any of the threads that
/// wait for the motion. Two threads may call two different functions at the same time.
class MotionWatcher {
 public:
  virtual ~MotionWatcher() = default;
  /// Returns whether the motion must end. When this function returns true, the arm decelerates on
  /// its path.
  virtual bool interrupted() = 0;
  /// Receives the progress of the motion: `fraction` is the passed part of the motion's duration, 0
  /// to 1; `remaining` is the time in s until it ends.
  virtual void progress(double fraction, double remaining) = 0;
  /// Receives the factor that scales the speed of motions; 0 pauses the motion. The arm calls this
  /// function before each call of `progress`.
  virtual void scaled(double factor) { static_cast<void>(factor); }
  /// Returns a number that identifies the caller of the motion. If a move fails, the later moves of
  /// the same caller are not made.
  virtual std::uint64_t caller() const { return 0; }
  /// Called when the arm has accepted the move. The caller may then request the next move.
  virtual void taken() {}
  /// Called when the arm will not stop at the goal, because it goes over into the next move. The
  /// tool passes the goal at the distance `distance`, in m.
  virtual void passes_goal(double distance) { static_cast<void>(distance); }
};

}  // namespace devices
