// The execution of a plan, one control cycle after the other.
#pragma once

#include <cstddef>

#include "robcl/motion/plan.hpp"
#include "robcl/motion/trajectory_generator.hpp"

namespace robcl::motion {

/// Computes the set points of the joints for each control cycle of a plan. Never allocates memory,
/// locks or logs.
class Playback final : public TrajectoryGenerator {
 public:
  explicit Playback(Plan plan);

  const JointValues& start() const override { return plan_.start(); }
  JointValues advance(double seconds) override;
  void set_override(double factor) override;

  /// Makes the following calls of `advance` decelerate on the path, as hard as the arm's limits
  /// allow, until the arm stands somewhere on the path.
  void stop() override;
  /// The arm stands where it is on the path, because it got no set points for a while. The
  /// following calls of `advance` accelerate from rest, and then follow the plan again. After
  /// `stop`, the motion has ended.
  void rest() override;

  bool standing() const override { return standing_; }
  bool stopping() const override { return mode_ == Mode::Braking; }
  /// Returns the fraction of the plan's duration that has passed, from 0 to 1. It does not rise
  /// after `stop`.
  double fraction() const override;
  /// Returns the remaining time to the goal in s; 0 after `stop` and at the goal. While the arm
  /// accelerates after `rest`, the time is too short; while the motion is paused, it is that of a
  /// motion that goes on at full speed.
  double remaining() const override;
  const Plan& plan() const { return plan_; }

 private:
  enum class Mode {
    OnTime,   ///< the motion follows the time law of the plan
    Braking,  ///< the motion brakes to rest, as hard as the limits allow
    Scaled    ///< the motion takes on the speed of the plan times the override, and keeps it
  };
  void leave_law(Mode mode);
  void advance_by_pieces(double seconds);
  void begin_piece();
  double end_of_interval() const { return plan_.path.place(piece_.knot + 1); }

  Plan plan_;
  Mode mode_ = Mode::OnTime;
  double time_ = 0;  // s since the start, by the time law of the plan; does not rise while braking
  double s_ = 0;
  double speed_ = 0;  // ds/dt
  bool standing_ = false;
  double override_ = 1;
  /// While the motion does not follow the time law: a part of the path, within one interval, on
  /// which d²s/dt² is constant.
  struct Piece {
    std::size_t knot = 0;  // the start of the interval
    double end = 0;        // s
    double acceleration = 0;
  };
  Piece piece_;
};

}  // namespace robcl::motion
