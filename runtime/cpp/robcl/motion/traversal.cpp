#include "robcl/motion/traversal.hpp"

#include <algorithm>
#include <cmath>

#include "robcl/motion/ceiling.hpp"

namespace robcl::motion {

Traversal::Traversal(const Stage& first)
    : stage_(&first),
      s_(first.plan.path.begin()),
      least_(first.plan.smoothing.cycles + 1, 0),
      greatest_(first.plan.smoothing.cycles + 1, 0) {}

void Traversal::advance(double seconds) {
  if (seconds > 0) {
    least_.add(infinite);
    greatest_.add(-infinite);
  }
  if (standing_) {
    note(0);
  } else if (mode_ == Mode::OnTime) {
    advance_by_law(seconds);
  } else {
    advance_by_pieces(seconds);
  }
}

/// Records that d²s/dt² has had the value `u` in this cycle.
void Traversal::note(double u) {
  least_.newest() = std::min(least_.newest(), u);
  greatest_.newest() = std::max(greatest_.newest(), u);
}

/// Records the least and the greatest d²s/dt² of the plan from the time `from` to the time `to`.
/// The two values may differ, because the motion may pass several knots in one cycle.
void Traversal::note_law(double from, double to) {
  const TimeLaw::Range range = plan().law.accelerations(from, to);
  note(range.least);
  note(range.greatest);
}

void Traversal::advance_by_law(double seconds) {
  const double before = time_;
  time_ += seconds;
  const Stage* const next = stage_->next.load();
  if (next != nullptr) {
    const double switches = plan().law.time_at(next->place_of_entry());
    if (before <= switches && switches <= time_) {
      note_law(before, switches);
      enter(*next);
      return advance_by_law(before + seconds - switches);
    }
  }
  const TimeLaw::State state = plan().law.at(time_);
  s_ = state.s;
  speed_ = state.speed;
  note_law(before, time_);
  standing_ = time_ >= plan().law.duration();
  if (standing_) time_ = plan().law.duration();
}

/// Enters each stage that takes over at the present place of the motion. Several stages may take
/// over at the same knot.
void Traversal::enter_stages_here() {
  for (const Stage* next = stage_->next.load(); next != nullptr && next->place_of_entry() == s_;
       next = stage_->next.load()) {
    enter(*next);
    knot_ = next->plan.entry;
  }
}

void Traversal::enter(const Stage& next) {
  stage_ = &next;
  time_ = next.plan.law.time(next.plan.entry);
}

void Traversal::set_override(double factor) {
  if (factor == override_) return;
  override_ = factor;
  const bool moves = !standing_ && plan().law.duration() > 0;
  if (moves && mode_ != Mode::Braking) leave_law(Mode::Scaled);
}

void Traversal::stop() {
  if (!standing_ && mode_ != Mode::Braking) leave_law(Mode::Braking);
}

void Traversal::rest(const Stage& stage, double s) {
  if (stage_ != &stage) enter(stage);
  s_ = s;
  speed_ = 0;
  least_.fill(0);
  greatest_.fill(0);
  standing_ = mode_ == Mode::Braking || plan().law.duration() <= 0;
  if (!standing_) leave_law(Mode::Scaled);
}

void Traversal::leave_law(Mode mode) {
  mode_ = mode;
  knot_ = plan().path.interval_at(s_);
}

/// Returns the values of d²s/dt² that are allowed up to the next knot.
///
/// Consider the time law of the plan, slowed by a constant factor so that it has the present speed
/// here. This slowed time law keeps all limits on the rest of the path (see PathBounds). Therefore
/// its d²s/dt² is allowed here, and the arm can always stop at or before the goal. In some bends, a
/// fast arm cannot brake yet. The least allowed d²s/dt² is then positive.
PathBounds::Interval Traversal::allowed() const {
  const TimeLaw& law = plan().law;
  const double x = squared(speed_), step = plan().path.step(knot_);
  auto allowed = plan().braking.over_rest(knot_, 1 - std::min(way_to_knot() / step, 1.0), x);
  const double u = law.acceleration(knot_);
  const double fastest = law.squares()[knot_ + 1] - 2 * u * way_to_knot();  // (ds/dt)² of the law
  const double slowed = fastest > 0 ? u * std::min(x / fastest, 1.0) : 0;
  allowed.lower = std::min(allowed.lower, slowed);
  allowed.upper = std::max(allowed.upper, slowed);
  return allowed;
}

/// Returns d²s/dt² for the motion to the next knot, or for `seconds` if this time is shorter.
double Traversal::acceleration(double seconds) const {
  if (way_to_knot() <= 0) return 0;
  const Smoothing& smoothing = plan().smoothing;
  const TimeLaw& law = plan().law;
  const Ceiling::State here{knot_, s_, squared(speed_)};
  const auto stays_below = [&](const Ceiling& ceiling, double u) {
    return ceiling.admits(here, {u, seconds, 0, 0});
  };
  const PathBounds::Interval allowed = this->allowed();
  const double change = smoothing.change(plan().braking.acceleration_limit(knot_));
  const double held = greatest_.greatest() - change;
  double u = std::max(allowed.lower, std::min(held, allowed.upper));
  if (mode_ == Mode::Scaled && override_ > 0) {
    const double most = std::max(u, std::min(allowed.upper, least_.least() + change));
    const Ceiling wanted(law.places(), law.squares(), squared(override_));
    u = greatest_admitted(u, most, [&](double some) {
      return stays_below(wanted, some) && (!smoothing.on() || can_slow_down(some, seconds, change));
    });
  }
  const Ceiling highest(law.places(), law.squares());
  const double stops = -here.x / (2 * way_to_knot());
  return greatest_admitted(std::min(stops, u), u,
                           [&](double some) { return stays_below(highest, some); });
}

/// Returns whether the motion can slow down in time after `seconds` with d²s/dt² = `u`. The limit
/// of jerk lets d²s/dt² fall by at most `change` within one window of the smoothing. Therefore the
/// plan, slowed to the speed of the motion, must not require a lower d²s/dt² than that anywhere
/// within this window.
bool Traversal::can_slow_down(double u, double seconds, double change) const {
  const Smoothing& smoothing = plan().smoothing;
  const TimeLaw& law = plan().law;
  const double speed = std::max(speed_ + u * seconds, 0.0), x = squared(speed);
  const double cycle = smoothing.window / static_cast<double>(smoothing.cycles);
  const double reached = s_ + speed * (smoothing.window + 2 * cycle);
  const double least = std::max(u, greatest_.greatest()) - change;
  for (std::size_t i = knot_; i < plan().path.intervals() && law.places()[i] < reached; ++i) {
    const double way = std::min(reached, law.places()[i + 1]) - law.places()[i];
    const double fastest = law.squares()[i] + 2 * std::min(law.acceleration(i), 0.0) * way;
    if (law.acceleration(i) * (x < fastest ? x / fastest : 1) < least) return false;
  }
  return true;
}

/// Continues with d²s/dt² = `u` to the next knot, or until the arm stands, but for at most
/// `seconds`. Returns the part of `seconds` that is left.
double Traversal::go_on(double u, double seconds) {
  const double end = plan().path.place(knot_ + 1), way = way_to_knot();
  const double left = squared(speed_) + 2 * u * way;  // (ds/dt)² at the knot
  const bool stops = left <= 0 && way > 0;
  const double after = stops ? 0 : std::sqrt(std::max(left, 0.0));
  const double lasts = stops     ? (speed_ > 0 ? speed_ / -u : 0)
                       : way > 0 ? 2 * way / (speed_ + after)
                                 : 0;
  if (seconds < lasts) {
    s_ = std::min(s_ + seconds * (speed_ + u * seconds / 2), end);
    speed_ = std::max(speed_ + u * seconds, 0.0);
    return 0;
  }
  s_ = stops ? std::min(s_ + lasts * speed_ / 2, end) : end;
  speed_ = after;
  return seconds - lasts;
}

/// Returns whether the motion can follow the time law from here. It can if it has the speed of the
/// time law, and if its acceleration can reach every acceleration that the time law has during the
/// next `Smoothing::window` seconds. @pre the motion is at a knot.
bool Traversal::can_follow_law() const {
  constexpr double rounding = 1e-6;  // relative
  const TimeLaw& law = plan().law;
  if (speed_ < law.speed(knot_) * (1 - rounding)) return false;
  const Smoothing& smoothing = plan().smoothing;
  for (std::size_t i = knot_; i < plan().path.intervals(); ++i) {
    if (law.time(i) - law.time(knot_) >= smoothing.window) break;
    const double change = smoothing.change(plan().braking.acceleration_limit(i));
    const double u = law.acceleration(i), slack = rounding * change;
    if (u < greatest_.greatest() - change - slack || u > least_.least() + change + slack)
      return false;
  }
  return true;
}

/// Returns whether rounding may have stopped the joints just before the goal: the remaining way can
/// be so short that `greatest_admitted` does not find the very small d²s/dt² that it needs.
bool Traversal::nearly_at_goal() const {
  constexpr double negligible = 1e-8;  // rad, or 1/s as ds/dt
  if (speed_ > negligible) return false;
  const Path& path = plan().path;
  const JointValues& goal = path.knot(path.intervals());
  const auto near_goal = [&](const JointValues& joints) {
    return (joints - goal).cwiseAbs().maxCoeff() <= negligible;
  };
  if (!near_goal(path.position(s_))) return false;
  for (std::size_t i = knot_ + 1; i < path.intervals(); ++i) {
    if (!near_goal(path.knot(i))) return false;
  }
  return true;
}

void Traversal::advance_by_pieces(double seconds) {
  if (mode_ == Mode::Scaled) enter_stages_here();
  while (seconds > 0) {
    const double u = acceleration(seconds);
    note(u);
    seconds = go_on(u, seconds);
    const Path& path = plan().path;
    if (mode_ == Mode::Scaled && nearly_at_goal()) s_ = path.end();
    const bool at_knot = s_ >= path.place(knot_ + 1);
    if (at_knot) ++knot_;
    if (at_knot && mode_ == Mode::Scaled) enter_stages_here();
    standing_ = knot_ == plan().path.intervals() || (speed_ == 0 && mode_ == Mode::Braking);
    if (standing_ || speed_ == 0) break;
    if (mode_ == Mode::Scaled && override_ == 1 && at_knot && can_follow_law()) {
      mode_ = Mode::OnTime;
      time_ = plan().law.time(knot_);
      return advance_by_law(seconds);
    }
  }
  if (mode_ == Mode::Scaled) {
    time_ = standing_ ? plan().law.duration() : std::max(time_, plan().law.time_at(s_));
  }
}

}  // namespace robcl::motion
