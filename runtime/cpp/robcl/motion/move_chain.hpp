// Moves that go over into each other, so that the arm does not stop between them.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "robcl/motion/line_deviation.hpp"
#include "robcl/motion/plan.hpp"
#include "robcl/motion/planner.hpp"

namespace robcl::motion {

/// Plans successive moves that go over into each other: the deceleration before the goal of a move
/// overlaps the acceleration of the next move. The arm therefore does not reach the goal, but
/// rounds a corner at a distance from the goal that is known in advance. Between the corners, the
/// arm moves on the path of each move.
///
/// Let the corner be at the nominal time s, and let d be half the nominal duration of the overlap.
/// At s + t, for t from -d to d, two displacements from the corner are added: the displacement at
/// d·f(1 - x) before the corner on the first path, and the displacement at d·f(x) behind the corner
/// on the second path, with x = (t + d)/2d. The function f rises from 0 to 1, and its second
/// derivative is a trapezoid, so that the path bends gradually. If both paths are straight lines,
/// the displacements are those of the tool, otherwise those of the joints. With the speed v, the
/// acceleration a and the directions u and w of the two lines, the tool passes the corner at the
/// distance |w - u|·v²/8a. A corner takes at most half of either move.
class MoveChain {
 public:
  /// Makes a chain that begins at rest with the move `first`. The planner must exist as long as the
  /// chain.
  MoveChain(Planner& planner, Move first);

  /// The place where one move goes over into the next one.
  struct Corner {
    double begins = 0, ends = 0;  ///< s in the chain
    double distance = 0;          ///< distance at which the tool passes the goal, m
    double angle = 0;             ///< angle of the tool from the goal at this place, rad
  };
  /// Adds the move `next`, which must start at goal(), to the chain without a stop. Does not change
  /// the motion before the time `after`. Returns nullopt, and changes nothing, if the arm cannot go
  /// over into `next`. The possible reasons are that the motion at `after` is already too near to
  /// the corner, that the corner is beyond a limit, that a motion with a stop would end sooner, or
  /// that a move has no length.
  std::optional<Corner> extend(const Move& next, double after);
  /// Adds successive moves and plans the motion only once. Returns the corner before each of the
  /// new moves. Returns nullopt, and changes nothing, if the moves cannot be planned together. The
  /// caller can then add the moves one after the other. @pre `next` has at least one move, and each
  /// starts at the goal of the one before.
  std::optional<std::vector<Corner>> extend(std::span<const Move> next, double after);

  // All times are in s since the start of the chain, by the time laws of its plans.

  /// Returns the plan for the rest of the motion, from the knot `Plan::entry` on.
  const Plan& plan() const { return plan_; }
  /// Returns the time at which the time law of plan() begins. The motion goes over into plan() at
  /// or after this time.
  double begins() const { return begins_; }
  double ends() const { return begins_ + plan_.law.duration(); }
  double end() const { return plan_.path.end(); }  ///< s
  const JointValues& goal() const { return plan_.goal(); }
  /// Returns the time at which the motion is at the place `s`; nullopt if the path of plan() begins
  /// behind `s`.
  std::optional<double> time_at(double s) const;

 private:
  /// The part of a path, from `begin` to `end` in s, on which the tool moves along `line`.
  struct LinePart {
    double begin = 0, end = 0;
    LineOnPath line;
    WayAndTurn speed, braking_speed;  ///< limits of the tool, in m/s and rad/s
  };
  /// A path with its limits.
  struct Course {
    Path::Knots knots;
    CourseLimits limits;
    std::vector<LinePart> lines;  ///< in the order of the path
  };
  /// The overlap of two moves. Both moves must outlive this object.
  struct Overlap {
    const Move& last;
    const Move& next;
    double corner = 0;              ///< s
    double half = 0;                ///< d
    double unhindered = 0;          ///< d, if both moves are long enough
    JointValues before{}, after{};  ///< joint positions where the overlap begins and ends

    double begins() const { return corner - half; }           ///< s
    double ends() const { return corner + half; }             ///< s
    double goal() const { return corner + next.duration(); }  ///< s at the goal of `next`
  };
  std::optional<std::size_t> first_knot_after(double time, double last_place) const;
  std::size_t first_in_window_before(std::size_t knot) const;
  Course course_between(std::size_t start, std::size_t entry, double end,
                        const JointValues& at_end) const;
  std::optional<JointValues> joints_on(const Move& move, const JointValues& near, double s);
  std::optional<std::vector<Overlap>> overlaps_with(std::span<const Move> next);
  std::pair<IntervalLimits, IntervalLimits> limits_in(const Overlap& overlap) const;
  bool add_overlap(Course& course, const Overlap& overlap);
  void add_move(Course& course, const Overlap& overlap, const Overlap* following) const;
  std::vector<Frame> flanges_in(const Overlap& overlap, std::size_t intervals) const;
  std::optional<std::vector<JointValues>> overlap_of_lines(const Overlap& overlap,
                                                           std::size_t intervals);
  std::vector<JointValues> overlap_of_joints(const Overlap& overlap, std::size_t intervals) const;
  std::optional<std::vector<JointValues>> overlap_joints(const Overlap& overlap,
                                                         std::size_t intervals);
  bool slower_than_stops(const Plan& plan, double begins,
                         const std::vector<Overlap>& overlaps) const;
  Corner corner_of(const Plan& plan, const Overlap& overlap) const;
  LinePart line_part(const Move& move, double begin, double end, double start) const;
  bool keeps_to_lines(Course& course, const Path& path) const;
  std::optional<Plan> plan_of(Course& course, const TimeLaw::Start& start) const;

  Planner& planner_;
  Course course_;
  Plan plan_;
  double begins_ = 0;
  Move last_;
};

}  // namespace robcl::motion
