#include "robcl/motion/time_law.hpp"

#include <algorithm>
#include <cmath>

#include "robcl/motion/ceiling.hpp"

namespace robcl::motion {
namespace {

using Interval = PathBounds::Interval;

constexpr double no_cap = 1e12;     // 1/s²: (ds/dt)² where no limit of speed holds
constexpr double rounding = 1e-12;  // relative
constexpr double rounding_of_start = 1e-9;

/// Returns the allowed values of u = d²s/dt² after the knot `knot`, where (ds/dt)² is `x`. With
/// these values, (ds/dt)² is at most `next` at the following knot. Returns an empty interval if the
/// limits of the arm would make (ds/dt)² fall below half of `x`.
Interval allowed(const PathBounds& bounds, std::size_t knot, double x, double next) {
  const double per_u = 2 * bounds.step(knot);
  Interval u = bounds.over_interval(knot, x);
  // If a bend is short compared to the interval, the limits would make a fast motion brake nearly
  // to a stop. A motion that is slower at the knot need not brake so much. Therefore the fast
  // motion is not allowed.
  Interval going_on = u;
  going_on.raise_lower(-x / (2 * per_u), -1 / (2 * per_u));
  if (going_on.empty()) return going_on;
  u.raise_lower(-x / per_u, -1 / per_u);
  u.reduce_upper((next - x) / per_u, -1 / per_u);
  return u;
}

/// Returns the greatest (ds/dt)² at the knot `knot` from which the arm can reach a (ds/dt)² of at
/// most `next` at the following knot.
///
/// The width of the interval of allowed values is a concave function of (ds/dt)², made of straight
/// pieces, and not negative at 0. Therefore Newton's method approaches the zero of this function
/// from above, in at most one step for each piece.
double fastest_at(const PathBounds& bounds, std::size_t knot, double next) {
  double x = std::min(bounds.speed_cap(knot), no_cap);
  // Because of rounding, the interval may still be empty at the zero. A slightly smaller value is
  // then allowed.
  for (double less = rounding; less < 1; less *= 2) {
    const Interval u = allowed(bounds, knot, x, next);
    if (!u.empty()) return x;
    const double zero = x + (u.lower - u.upper) / (u.upper_per_x - u.lower_per_x);
    x = std::max(0.0, std::min(zero, x * (1 - less)));
  }
  return 0;
}

/// Computes (ds/dt)² at the knots of a time law, one knot after the other.
class ForwardPass {
 public:
  /// `highest`: the greatest (ds/dt)² at each knot from which the arm can stop in time.
  ForwardPass(const PathBounds& bounds, const Smoothing& smoothing,
              const std::vector<double>& highest, const TimeLaw::Start& start)
      : bounds_(bounds),
        smoothing_(smoothing),
        ceiling_(bounds.places(), highest),
        highest_(highest) {
    for (std::size_t i = 0; i < bounds.intervals(); ++i) {
      limits_.push_back(bounds.acceleration_limit(i));
    }
    for (const double square : start.squares) add(square);
  }

  std::vector<double> run() && {
    for (std::size_t i = squares_.size() - 1; i < bounds_.intervals(); ++i) {
      const double x = squares_[i], top = highest_[i + 1];
      const double u = acceleration(i, allowed(bounds_, i, x, top));
      add(std::clamp(x + 2 * bounds_.step(i) * u, 0.0, top));
    }
    return std::move(squares_);
  }

 private:
  /// Adds (ds/dt)² at the next knot.
  void add(double square) {
    squares_.push_back(square);
    if (squares_.size() == 1) return;
    const std::size_t i = squares_.size() - 2;
    const double speeds = std::sqrt(squares_[i]) + std::sqrt(square);
    times_.push_back(speeds > 0 ? 2 * bounds_.step(i) / speeds : infinite);
  }

  double acceleration(std::size_t knot, const Interval& allowed) const {
    if (!smoothing_.on() || allowed.empty()) return allowed.upper;
    const Window window = in_window_before(knot);
    const auto& before = window.range;
    const double change = smoothing_.change(window.limit);
    const double lowest = std::max(allowed.lower, before.greatest - change);
    // After hard braking, the limit of jerk may require that the motion goes on braking. This code
    // never makes the motion brake harder than is needed to stop within one window, even if the
    // motion then exceeds the limit of jerk.
    const double still = -std::sqrt(squares_[knot]) / smoothing_.window;
    const double highest = std::min(allowed.upper, std::max(before.least + change, still));
    const Ceiling::State here{knot, bounds_.places()[knot], squares_[knot]};
    const double u = greatest_admitted(lowest, highest, [&](double some) {
      const double then = std::max(some, before.greatest) - change;
      return ceiling_.admits(here, {some, infinite, then, smoothing_.window, true});
    });
    // If no acceleration keeps the limit of jerk, the motion exceeds this limit here, because it
    // must not stop before its goal.
    const double slower = -here.x / (4 * bounds_.step(knot));  // halves (ds/dt)²
    return std::clamp(std::max(u, slower), allowed.lower, allowed.upper);
  }

  /// The accelerations in a window, and the greatest limit of d²s/dt² there.
  struct Window {
    TimeLaw::Range range{infinite, -infinite};
    double limit = 0;
  };
  /// Returns the accelerations in the window before `knot`, and the greatest limit in this window
  /// and in the interval after `knot`. If the motion begins within the window, it begins at rest:
  /// the acceleration 0 of the standing arm is then included.
  Window in_window_before(std::size_t knot) const {
    double since = 0;
    Window window{.limit = limits_[knot]};
    for (std::size_t i = knot; since < smoothing_.window; --i) {
      if (i == 0) {
        window.range.add(0);
        break;
      }
      window.range.add((squares_[i] - squares_[i - 1]) / (2 * bounds_.step(i - 1)));
      window.limit = std::max(window.limit, limits_[i - 1]);
      since += times_[i - 1];
    }
    return window;
  }

  const PathBounds& bounds_;
  const Smoothing& smoothing_;
  const Ceiling ceiling_;
  const std::vector<double>& highest_;
  std::vector<double> limits_;  // of d²s/dt² in each interval
  std::vector<double> squares_, times_;
};

}  // namespace

std::optional<TimeLaw> TimeLaw::fastest(const PathBounds& bounds, const Start& start,
                                        const Smoothing& smoothing) {
  const std::size_t last = bounds.intervals();
  std::vector<double> highest(last + 1, 0.0);
  const std::size_t first = start.knot();
  for (std::size_t i = last; i-- > first;) highest[i] = fastest_at(bounds, i, highest[i + 1]);
  if (start.squares.back() > highest[first] * (1 + rounding_of_start)) return std::nullopt;
  std::copy_n(start.squares.begin(), first, highest.begin());
  TimeLaw law(bounds.places(), ForwardPass(bounds, smoothing, highest, start).run());
  if (!std::isfinite(law.duration())) return std::nullopt;
  return law;
}

std::vector<double> TimeLaw::change_excess(const PathBounds& bounds,
                                           const Smoothing& smoothing) const {
  std::vector<double> factors(bounds.intervals(), 1);
  const double window = smoothing.window * (1 - 1e-9);  // but for rounding
  for (std::size_t i = 1; smoothing.on() && i < bounds.intervals(); ++i) {
    const double limit = bounds.acceleration_limit(i);
    for (std::size_t j = i; j > 0 && times_[i] - times_[j] < window; --j) {
      const double change = smoothing.change(std::max(limit, bounds.acceleration_limit(j - 1)));
      const double apart = std::abs(acceleration(i) - acceleration(j - 1));
      if (apart <= change) continue;
      const auto begin = factors.begin() + static_cast<std::ptrdiff_t>(j - 1);
      const auto end = factors.begin() + static_cast<std::ptrdiff_t>(i + 1);
      const double factor = std::sqrt(apart / change);
      std::transform(begin, end, begin, [&](double other) { return std::max(other, factor); });
    }
  }
  return factors;
}

TimeLaw::Range TimeLaw::accelerations(double from, double to) const {
  const double first = at(from).acceleration, last = at(to).acceleration;
  Range range{std::min(first, last), std::max(first, last)};
  for (std::size_t i = knot_at(from) + 1; i + 1 < times_.size() && times_[i] < to; ++i) {
    range.add(acceleration(i));
  }
  return range;
}

std::size_t TimeLaw::knot_at(double seconds) const {
  const auto after = std::upper_bound(times_.begin() + 1, times_.end(), seconds);
  return static_cast<std::size_t>(after - times_.begin()) - 1;
}

TimeLaw TimeLaw::standing() {
  TimeLaw law({0, 0}, {0, 0});
  law.times_ = {0, 0};
  return law;
}

TimeLaw::TimeLaw(std::vector<double> places, std::vector<double> squared_speeds)
    : places_(std::move(places)), squares_(std::move(squared_speeds)) {
  double time = 0;
  for (std::size_t i = 0; i < squares_.size(); ++i) {
    speeds_.push_back(std::sqrt(squares_[i]));
    if (i > 0) time += 2 * (places_[i] - places_[i - 1]) / (speeds_[i - 1] + speeds_[i]);
    times_.push_back(time);
  }
}

TimeLaw TimeLaw::slowed(double factor) const {
  TimeLaw slower = *this;
  for (double& time : slower.times_) time *= factor;
  for (double& speed : slower.speeds_) speed /= factor;
  for (double& square : slower.squares_) square /= squared(factor);
  return slower;
}

TimeLaw::State TimeLaw::at(double seconds) const {
  if (seconds >= duration()) return {places_.back(), 0, 0};
  if (seconds <= 0) return {places_.front() + seconds * speeds_.front(), speeds_.front(), 0};
  const std::size_t i = knot_at(seconds);
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
