// The execution of a plan, one control cycle after the other.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>

#include "robcl/motion/plan.hpp"
#include "robcl/motion/trajectory_generator.hpp"

namespace robcl::motion {

/// Computes the set points of the joints for each control cycle of a plan. Except for `append` and
/// `elapsed`, only the control loop calls these functions; they never allocate memory, lock or log.
class Playback final : public TrajectoryGenerator {
 public:
  explicit Playback(Plan plan);

  /// Makes the motion go over into `plan`, whose path begins at a knot of the last plan, with the
  /// position, slope and speed ds/dt of that plan; `begins` is the time of that knot by the time
  /// laws of all plans so far, in s. If the motion has passed this time already, or brakes, it ends
  /// as without `plan`. Any one thread may call this function.
  void append(Plan plan, double begins);
  /// Returns the number of the plan that the motion follows: 0 for the first one, 1 for the first
  /// one that was appended. Only the thread that appends may call this function.
  std::size_t entered() const { return entered_.load()->number; }
  /// Returns the time in s since the start, by the time laws of the plans: while an override slows
  /// the motion, it rises more slowly than time, and after `stop` it stands. Any thread may call
  /// this function.
  double elapsed() const { return elapsed_.load(); }

  const JointValues& start() const override { return start_; }
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
  /// after `stop`. It counts from the start of the plan that the motion follows now.
  double fraction() const override;
  /// Returns the remaining time to the goal in s; 0 after `stop` and at the goal. While the arm
  /// accelerates after `rest`, the time is too short; while the motion is paused, it is that of a
  /// motion that goes on at full speed.
  double remaining() const override;

 private:
  /// A plan, and the one that takes over from it.
  struct Stage {
    Stage(Plan its_plan, double its_begin, std::size_t its_number)
        : plan(std::move(its_plan)), begins(its_begin), number(its_number) {}
    const Plan plan;
    const double begins;  // s, by the time laws of the plans before it
    const std::size_t number;
    std::atomic<const Stage*> next{nullptr};
  };
  enum class Mode {
    OnTime,   ///< the motion follows the time law of the plan
    Braking,  ///< the motion brakes to rest, as hard as the limits allow
    Scaled    ///< the motion takes on the speed of the plan times the override, and keeps it
  };
  const Plan& plan() const { return stage_->plan; }
  void advance_by_law(double seconds);
  bool enter_stages_here();
  void enter(const Stage& next);
  void leave_law(Mode mode);
  void advance_by_pieces(double seconds);
  void begin_piece();
  void begin_last_piece(double way, double part, double x, double most);
  double end_of_interval() const { return plan().path.place(piece_.knot + 1); }

  std::deque<std::unique_ptr<Stage>> stages_;  // used by the thread that appends
  std::atomic<const Stage*> entered_;          // the stages before it are not used any more
  std::atomic<double> elapsed_{0};             // orders no other memory

  const JointValues start_;
  const Stage* stage_;
  Mode mode_ = Mode::OnTime;
  // s since the start of the stage, by the time law of its plan; does not rise while braking
  double time_ = 0;
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
    bool brakes_after = false;  // from the end of this piece to the goal
  };
  Piece piece_;
};

}  // namespace robcl::motion
