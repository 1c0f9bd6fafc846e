#include "robcl/motion/ceiling.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {
namespace {

constexpr double slightly = 1e-12;  // relative, for rounding

}  // namespace

double Ceiling::height(std::size_t knot, double s) const {
  const double part = (s - places_[knot]) / (places_[knot + 1] - places_[knot]);
  return factor_ *
         (squares_[knot] + std::clamp(part, 0.0, 1.0) * (squares_[knot + 1] - squares_[knot]));
}

/// Moves `state` with d²s/dt² = `u` to the next knot. Moves it for `seconds` instead if the knot is
/// not reached by then and `whole` is false, or if the motion cannot reach the knot.
/// When the motion reaches the knot, subtracts the time that it took from `seconds`.
Ceiling::Step Ceiling::step(State& state, double u, double& seconds, bool whole) const {
  const double tolerance =
      slightly * factor_ * std::max(squares_[state.knot], squares_[state.knot + 1]);
  const double speed = std::sqrt(state.x);
  const double way = std::max(places_[state.knot + 1] - state.s, 0.0);
  const double left = state.x + 2 * u * way;
  if (left >= 0) {
    const double after = std::sqrt(left);
    const double lasts = way > 0 ? 2 * way / (speed + after) : 0;
    if (lasts <= seconds || whole) {
      seconds -= lasts;
      state = {state.knot + 1, places_[state.knot + 1], left};
      return left <= factor_ * squares_[state.knot] + tolerance ? Step::Knot : Step::Above;
    }
  }
  const double after = speed + u * seconds;
  if (after <= 0) return Step::Stopped;
  state.s += seconds * (speed + after) / 2;
  state.x = after * after;
  return state.x <= height(state.knot, state.s) + tolerance ? Step::Time : Step::Above;
}

bool Ceiling::admits(State state, const Course& course) const {
  double seconds = course.seconds, hold = course.hold;
  const std::size_t last = places_.size() - 1;
  Step reached = step(state, course.u, seconds, course.whole);
  while (reached == Step::Knot || reached == Step::Time) {
    if (state.knot == last || hold <= 0) return true;
    reached = step(state, course.then, hold, course.whole);
    if (reached == Step::Time) return true;
  }
  return reached != Step::Above;
}

}  // namespace robcl::motion
