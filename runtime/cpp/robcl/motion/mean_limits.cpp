#include "robcl/motion/mean_limits.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {
namespace {

constexpr double most_reduced = 0.5;  // of a limit
// A motion may leave its time law at any time. The mean over the window is then a mean of two
// motions.
constexpr double reserve = 0.006;          // of the limits of acceleration
constexpr double braking_reserve = 0.012;  // the same, for a motion that is not known beforehand
constexpr int samples = 30;                // in a window
constexpr int finer = 4;                   // times as many, where the motion is close to a limit
constexpr double close = 0.98;             // of the greatest speed
// The maximum for a motion that takes minutes or days. Such a motion changes little within a
// window.
constexpr int most_samples = 20'000;

/// The bend of a path: the second and third derivative of a joint, divided by the joint's limit of
/// acceleration. For each derivative, the joint with the greatest quotient counts.
struct Bend {
  double second = 0, third = 0;
  double jump = 0;  ///< of the second derivative, at the start of the interval

  void extend(const Bend& other) {
    second = std::max(second, other.second);
    third = std::max(third, other.third);
    jump = std::max(jump, other.jump);
  }
};

/// Returns the bend of each interval.
std::vector<Bend> bends_of(const Path& path, const arm::ArmModel& model) {
  std::vector<Bend> bends(path.intervals());
  JointValues before;  // the second derivative at the end of the interval before
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const JointValues start = path.derivatives(i, 0).curvature;
    const JointValues end = path.derivatives(i, 1).curvature;
    for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
      const double limit = model.limits()[static_cast<std::size_t>(axis)].acceleration;
      const double one = start[axis] / limit, other = end[axis] / limit;
      bends[i].second = std::max({bends[i].second, std::abs(one), std::abs(other)});
      bends[i].third = std::max(bends[i].third, std::abs(other - one) / path.step(i));
      if (i > 0) bends[i].jump = std::max(bends[i].jump, std::abs(one - before[axis] / limit));
    }
    before = end;
  }
  return bends;
}

/// Returns the factor by which a motion with this state must be slowed; 1 or less if it keeps the
/// limits of the joints.
double excess(const Path& path, const arm::ArmModel& model, const IntervalLimits& limits,
              const TimeLaw::State& state) {
  const std::size_t here = path.interval_at(state.s);
  const double part = std::clamp((state.s - path.place(here)) / path.step(here), 0.0, 1.0);
  const auto [slope, curvature] = path.derivatives(here, part);
  double factor = 0;
  for (Eigen::Index axis = 0; axis < model.axes(); ++axis) {
    const auto& of_joint = model.limits()[static_cast<std::size_t>(axis)];
    const double speed = slope[axis] * state.speed;
    const double acceleration =
        slope[axis] * state.acceleration + curvature[axis] * squared(state.speed);
    const double fastest = of_joint.speed * limits.speed;
    const double most = (1 - reserve) * of_joint.acceleration * limits.acceleration;
    factor =
        std::max({factor, std::abs(speed) / fastest, std::sqrt(std::abs(acceleration) / most)});
  }
  return factor;
}

/// The mean of the last places of a time law, over a window of time.
class MeanMotion {
 public:
  MeanMotion(const TimeLaw& law, const TimeLaw::Start& start, double window)
      : law_(law), start_(start), window_(window), integrals_{0} {
    for (std::size_t i = 0; i + 1 < law.places().size(); ++i) {
      integrals_.push_back(integrals_.back() + since_knot(i, law.time(i + 1) - law.time(i)));
    }
  }

  /// Returns the state of the time law, also before it starts.
  TimeLaw::State of_law(double time) const {
    return time < 0 && start_.before ? start_.before(time) : law_.at(time);
  }

  /// Returns the state of the mean at the end of the window that ends at `time`.
  TimeLaw::State at(double time) const {
    const TimeLaw::State begin = of_law(time - window_), end = of_law(time);
    return {(integral(time) - integral(time - window_)) / window_, (end.s - begin.s) / window_,
            (end.speed - begin.speed) / window_};
  }

 private:
  /// Returns the integral of s from the time 0 to `time`.
  double integral(double time) const {
    const double s = law_.places().front();
    if (time < 0 && start_.before) {  // by Simpson's rule
      return time * (s + 4 * start_.before(time / 2).s + start_.before(time).s) / 6;
    }
    if (time <= 0) return time * (s + time * law_.speed(0) / 2);
    const double after = time - law_.duration();
    if (after >= 0) return integrals_.back() + after * law_.places().back();
    const std::size_t knot = law_.knot_at(time);
    return integrals_[knot] + since_knot(knot, time - law_.time(knot));
  }

  double since_knot(std::size_t knot, double t) const {
    const double speed = law_.speed(knot), acceleration = law_.acceleration(knot);
    return t * (law_.places()[knot] + t * (speed / 2 + t * acceleration / 6));
  }

  const TimeLaw& law_;
  const TimeLaw::Start& start_;
  const double window_;
  std::vector<double> integrals_;  // of s, up to each knot
};

}  // namespace

std::vector<double> excess_of_mean(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits, const TimeLaw& law,
                                   const TimeLaw::Start& start, const Smoothing& smoothing) {
  const double window = smoothing.window;
  const MeanMotion motion(law, start, window);
  const auto excess_at = [&](double time) {
    const TimeLaw::State mean = motion.at(time);
    const bool before = mean.s < path.begin() && start.path_before != nullptr;
    const IntervalLimits& here = limits[path.interval_at(mean.s)];
    return excess(before ? *start.path_before : path, model, here, mean);
  };
  std::vector<double> factors(path.intervals(), 1);
  std::size_t first = 0;  // of the intervals in the window
  const double step = std::max(window / samples, law.duration() / most_samples);
  for (double time = 0; time < law.duration() + window; time += step) {
    double factor = excess_at(time);
    for (int part = 1; factor > close && part < finer; ++part) {
      factor = std::max(factor, excess_at(time + part * step / finer));
    }
    const double begin = motion.of_law(time - window).s, end = motion.of_law(time + step).s;
    while (first + 1 < path.intervals() && path.place(first + 1) < begin) ++first;
    for (std::size_t i = first; factor > 1 && i < path.intervals() && path.place(i) <= end; ++i) {
      factors[i] = std::max(factors[i], factor);
    }
  }
  return factors;
}

std::vector<IntervalLimits> narrowed(const Path& path, const arm::ArmModel& model,
                                     std::vector<IntervalLimits> limits, const TimeLaw& fastest,
                                     const Smoothing& smoothing) {
  const PathBounds bounds(path, model, limits);
  const std::vector<Bend> bends = bends_of(path, model);
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    const double speed = std::max(fastest.speed(i), fastest.speed(i + 1));
    const double travel = speed * smoothing.window;
    const double first = path.place(i) - travel / 2, last = path.place(i + 1) + travel / 2;
    Bend bend = bends[i];
    for (std::size_t j = i; j > 0 && path.place(j) > first; --j) bend.extend(bends[j - 1]);
    for (std::size_t j = i + 1; j < path.intervals() && path.place(j) < last; ++j) {
      bend.extend(bends[j]);
    }
    const double u = bounds.over_interval(i, 0).upper;
    const double change = std::min(smoothing.change(bounds.acceleration_limit(i)), 2 * u);
    // How far the mean of second * (ds/dt)² + first * d²s/dt² may exceed the limit, from the
    // covariances and variances within a window.
    const double by = braking_reserve +
                      bend.second * (travel * change / 4 + squared(u * smoothing.window) / 12) +
                      bend.third * travel * (travel * u * 5 / 24 + squared(speed) / 6) +
                      bend.jump * squared(speed) * 2 / 3;
    limits[i].acceleration *= 1 - std::min(by, most_reduced);
  }
  return limits;
}

}  // namespace robcl::motion
