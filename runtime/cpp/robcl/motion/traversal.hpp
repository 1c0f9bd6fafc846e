// The progress of a motion on its path.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "robcl/motion/moving_window.hpp"
#include "robcl/motion/plan.hpp"

namespace robcl::motion {

/// A plan of a motion, and the stage with the plan that follows.
struct Stage {
  Stage(Plan its_plan, double its_begin, std::size_t its_number)
      : plan(std::move(its_plan)), begins(its_begin), number(its_number) {}
  const Plan plan;
  const double begins;  ///< time in s at which its time law begins, by the earlier time laws
  const std::size_t number;
  std::atomic<const Stage*> next{nullptr};

  /// Returns s at the knot at which a motion goes over into this stage.
  double place_of_entry() const { return plan.path.place(plan.entry); }
};

/// Computes the path parameter s of a motion for each control cycle. The motion follows the time
/// laws of its plans, and leaves them when it is slowed or stopped. The motion keeps the limits of
/// the arm. It is never faster than the plan, because at a higher speed there may be no d²s/dt²
/// that keeps the limits. Only the control loop calls these functions; they never allocate memory,
/// lock or log.
class Traversal {
 public:
  explicit Traversal(const Stage& first);

  void advance(double seconds);
  void set_override(double factor);
  double speed_override() const { return override_; }
  /// Decelerates as hard as the limits allow, and ends the motion where it stands.
  void stop();
  /// Continues the motion from rest at the place `s` of `stage`. If `stop` was called before, the
  /// motion ends instead.
  void rest(const Stage& stage, double s);

  const Stage& stage() const { return *stage_; }
  double s() const { return s_; }
  /// Returns the time in s by the time law of the stage's plan. A motion that goes over into the
  /// stage begins at the time of `Plan::entry`, not at 0. The time does not rise while the motion
  /// brakes.
  double time() const { return time_; }
  bool standing() const { return standing_; }
  bool stopping() const { return mode_ == Mode::Braking; }

 private:
  enum class Mode {
    OnTime,   ///< the motion follows the time law of the plan
    Braking,  ///< the motion brakes to rest, as hard as the limits allow
    Scaled    ///< the motion takes on the speed of the plan times the override, and keeps it
  };
  const Plan& plan() const { return stage_->plan; }
  bool paused() const { return mode_ == Mode::Scaled && override_ == 0; }
  void advance_by_law(double seconds);
  void advance_by_pieces(double seconds);
  double go_on(double u, double seconds);
  double way_to_knot() const { return std::max(plan().path.place(knot_ + 1) - s_, 0.0); }
  PathBounds::Interval allowed() const;
  double acceleration(double seconds) const;
  bool can_slow_down(double u, double seconds, double change) const;
  bool can_follow_law() const;
  bool nearly_at_goal() const;
  void note(double u);
  void note_law(double from, double to);
  void leave_law(Mode mode);
  void enter(const Stage& next);
  void enter_stages_here();

  const Stage* stage_;
  Mode mode_ = Mode::OnTime;
  double time_ = 0;
  double s_ = 0;
  double speed_ = 0;      // ds/dt
  std::size_t knot_ = 0;  // of the interval, while the motion does not follow the time law
  bool standing_ = false;
  double override_ = 1;
  MovingWindow least_, greatest_;  // d²s/dt² in each of the last cycles
};

}  // namespace robcl::motion
