#pragma once

namespace devices {

/// The interface through which a running motion reports its progress to its caller, and asks
/// whether the caller interrupts the motion. The arm calls these functions about every 5 ms, one at
/// a time, on any thread that moves it.
class MotionWatcher {
 public:
  virtual ~MotionWatcher() = default;
  /// Returns whether the motion must end. When this function returns true, the arm decelerates on
  /// its path.
  virtual bool interrupted() = 0;
  /// Receives the progress of the motion: `fraction` is the passed part of the motion's duration, 0
  /// to 1; `remaining` is the time in s until it ends.
  virtual void progress(double fraction, double remaining) = 0;
  /// The arm has taken the move, and may get the next one.
  virtual void taken() {}
  /// Tells that the arm will not stop at the goal, because it goes over into the next move. It
  /// passes the goal at the distance `distance`, in m.
  virtual void passes_goal(double distance) { static_cast<void>(distance); }
};

}  // namespace devices
