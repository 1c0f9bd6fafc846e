#include "robcl/motion/time_law.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {
namespace {

using Interval = PathBounds::Interval;

constexpr double no_cap = 1e12;     // 1/s²: (ds/dt)² where no limit of speed holds
constexpr double rounding = 1e-12;  // relative
constexpr double rounding_of_start = 1e-9;

/// Returns the allowed values of u = d²s/dt² after the knot `knot`, where (ds/dt)² is `x`. With
/// these values, (ds/dt)² is at most `next` at the following knot.
Interval allowed(const PathBounds& bounds, std::size_t knot, double x, double next) {
  Interval u = bounds.over_interval(knot, x);
  const double per_u = 2 * bounds.step(knot);
  u.raise_lower(-x / per_u, -1 / per_u);
  u.reduce_upper((next - x) / per_u, -1 / per_u);
  return u;
}

/// Returns the greatest (ds/dt)² at the knot `knot` from which the arm can reach a (ds/dt)² of at
/// most `next` at the following knot.
///
/// The width of the interval of allowed values is a concave function of (ds/dt)², made of straight
/// pieces, and not negative at 0. So Newton's method comes from above to its zero, in as many
/// steps as there are pieces on the way.
double fastest_at(const PathBounds& bounds, std::size_t knot, double next) {
  double x = std::min(bounds.speed_cap(knot), no_cap);
  // Beside the zero, rounding may leave the interval empty: there, a little less is allowed.
  for (double less = rounding; less < 1; less *= 2) {
    const Interval u = allowed(bounds, knot, x, next);
    if (!u.empty()) return x;
    const double zero = x + (u.lower - u.upper) / (u.upper_per_x - u.lower_per_x);
    x = std::max(0.0, std::min(zero, x * (1 - less)));
  }
  return 0;
}

}  // namespace

std::optional<TimeLaw> TimeLaw::fastest_from(const PathBounds& bounds, double speed) {
  const std::size_t last = bounds.intervals();
  std::vector<double> squared(last + 1, 0.0);
  for (std::size_t i = last; i-- > 0;) squared[i] = fastest_at(bounds, i, squared[i + 1]);
  const double start = speed * speed;
  if (start > squared[0] * (1 + rounding_of_start)) return std::nullopt;
  squared[0] = start;
  for (std::size_t i = 0; i < last; ++i) {
    const Interval u = allowed(bounds, i, squared[i], squared[i + 1]);
    squared[i + 1] = std::clamp(squared[i] + 2 * bounds.step(i) * u.upper, 0.0, squared[i + 1]);
  }
  return TimeLaw(bounds.places(), squared);
}

TimeLaw TimeLaw::standing() {
  TimeLaw law({0, 0}, {0, 0});
  law.times_ = {0, 0};
  return law;
}

TimeLaw::TimeLaw(std::vector<double> places, const std::vector<double>& squared_speeds)
    : places_(std::move(places)) {
  double time = 0;
  for (std::size_t i = 0; i < squared_speeds.size(); ++i) {
    speeds_.push_back(std::sqrt(squared_speeds[i]));
    if (i > 0) time += 2 * (places_[i] - places_[i - 1]) / (speeds_[i - 1] + speeds_[i]);
    times_.push_back(time);
  }
}

TimeLaw TimeLaw::slowed(double factor) const {
  TimeLaw slower = *this;
  for (double& time : slower.times_) time *= factor;
  for (double& speed : slower.speeds_) speed /= factor;
  return slower;
}

TimeLaw::State TimeLaw::at(double seconds) const {
  if (seconds >= duration()) return {places_.back(), 0, 0};
  if (seconds <= 0) return {places_.front(), speeds_.front(), 0};
  const auto after = std::upper_bound(times_.begin(), times_.end(), seconds);
  const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
  const double acceleration = (speeds_[i + 1] - speeds_[i]) / (times_[i + 1] - times_[i]);
  const double since = seconds - times_[i];
  return {places_[i] + since * (speeds_[i] + acceleration * since / 2),
          speeds_[i] + acceleration * since, acceleration};
}

double TimeLaw::time_at(double s) const {
  const auto after = std::upper_bound(places_.begin() + 1, places_.end() - 1, s);
  const auto i = static_cast<std::size_t>(after - places_.begin()) - 1;
  const double step = places_[i + 1] - places_[i];
  const double way = std::clamp(s - places_[i], 0.0, step);
  const double before = speeds_[i] * speeds_[i], end = speeds_[i + 1] * speeds_[i + 1];
  const double speed =
      std::sqrt(before + way / step * (end - before));  // its square is linear in s
  if (way <= 0) return times_[i];
  return times_[i] + 2 * way / (speeds_[i] + speed);
}

}  // namespace robcl::motion
