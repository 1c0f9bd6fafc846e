#include "robcl/motion/mean_limits.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::motion {
namespace {

// The greatest reduction of a limit, as a fraction of the limit. In the sharpest corners of short
// moves, a reduction by less than 0.7 was not enough.
constexpr double most_reduced = 0.8;
// The part of the limits of acceleration that a time law must not use. A motion may leave its time
// law at any time, for example to brake. Then the window contains parts of two motions, and the
// mean acceleration over both parts can be greater than the limit that each motion keeps.
constexpr double reserve = 0.014;  // of the limits of acceleration
constexpr int samples = 30;        // in a window
// The maximum number of samples of a motion. Only motions that take minutes or days reach this
// number. Such a slow motion changes little within a window, so the samples may be further apart.
constexpr int most_samples = 20'000;

/// The bend of a part of a path: the second and the third derivative of a joint position by s, both
/// divided by the joint's limit of acceleration. For each derivative, the joint with the greatest
/// quotient counts.
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

/// The smoothed motion: at each time, the mean of the places s that a time law has in the window
/// that ends at this time.
class MeanMotion {
 public:
  MeanMotion(const TimeLaw& law, double window) : law_(law), window_(window), integrals_{0} {
    for (std::size_t i = 0; i + 1 < law.places().size(); ++i) {
      integrals_.push_back(integrals_.back() + since_knot(i, law.time(i + 1) - law.time(i)));
    }
  }

  /// Returns the state of the smoothed motion at `time`: the means of s, ds/dt and d²s/dt² in the
  /// window that ends at `time`.
  TimeLaw::State at(double time) const {
    const TimeLaw::State begin = law_.at(time - window_), end = law_.at(time);
    return {(integral(time) - integral(time - window_)) / window_, (end.s - begin.s) / window_,
            (end.speed - begin.speed) / window_};
  }

 private:
  /// Returns the integral of s from the time 0 to `time`. @pre `time` is not before 0, or the
  /// motion begins at rest.
  double integral(double time) const {
    if (time <= 0) return time * law_.places().front();
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
  const double window_;
  std::vector<double> integrals_;  // of s, up to each knot
};

/// Computes by how much the states of a smoothed motion exceed the limits of the joints.
class MeanJudge {
 public:
  MeanJudge(const Path& path, const arm::ArmModel& model, const std::vector<IntervalLimits>& limits)
      : path_(path), model_(model), limits_(limits) {}

  double excess_at(const TimeLaw::State& mean) const {
    const std::size_t here = path_.interval_at(mean.s);
    const double part = (mean.s - path_.place(here)) / path_.step(here);
    return excess(here, std::clamp(part, 0.0, 1.0), mean);
  }

  /// Returns the greatest excess at the knots between the states `from` and `to` of a motion. A
  /// corner can be so short that it lies between these two states.
  double excess_at_knots(const TimeLaw::State& from, const TimeLaw::State& to) const {
    double factor = 0;
    for (std::size_t i = path_.interval_at(from.s) + 1; i < path_.intervals(); ++i) {
      if (path_.place(i) >= to.s) break;
      const double part = (path_.place(i) - from.s) / (to.s - from.s);
      const TimeLaw::State here{path_.place(i), std::lerp(from.speed, to.speed, part),
                                std::lerp(from.acceleration, to.acceleration, part)};
      factor = std::max({factor, excess(i - 1, 1, here), excess(i, 0, here)});
    }
    return factor;
  }

 private:
  /// Returns the factor by which a motion must be slowed if it has the state `state` at the
  /// fraction `part` of the interval `here`. The factor is 1 or less if the motion keeps the limits
  /// of the joints.
  double excess(std::size_t here, double part, const TimeLaw::State& state) const {
    const auto [slope, curvature] = path_.derivatives(here, part);
    double factor = 0;
    for (Eigen::Index axis = 0; axis < model_.axes(); ++axis) {
      const auto& of_joint = model_.limits()[static_cast<std::size_t>(axis)];
      const double speed = slope[axis] * state.speed;
      const double acceleration =
          slope[axis] * state.acceleration + curvature[axis] * squared(state.speed);
      const double fastest = of_joint.speed * limits_[here].speed;
      const double most = (1 - reserve) * of_joint.acceleration * limits_[here].acceleration;
      factor =
          std::max({factor, std::abs(speed) / fastest, std::sqrt(std::abs(acceleration) / most)});
    }
    return factor;
  }

  const Path& path_;
  const arm::ArmModel& model_;
  const std::vector<IntervalLimits>& limits_;
};

}  // namespace

std::vector<double> excess_of_mean(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits, const TimeLaw& law,
                                   std::size_t from_knot, const Smoothing& smoothing) {
  const double window = smoothing.window;
  const MeanMotion motion(law, window);
  const MeanJudge judge(path, model, limits);
  std::vector<double> factors(path.intervals(), 1);
  std::size_t first = 0;  // of the intervals in the window
  const double step = std::max(window / samples, law.duration() / most_samples);
  TimeLaw::State mean = motion.at(law.time(from_knot));
  for (double time = law.time(from_knot); time < law.duration() + window; time += step) {
    const TimeLaw::State next = motion.at(time + step);
    const double factor = std::max(judge.excess_at(mean), judge.excess_at_knots(mean, next));
    mean = next;
    const double begin = law.at(time - window).s, end = law.at(time + step).s;
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
    // An upper limit of the excess, as a fraction of the limit: by how much the mean acceleration
    // q''·(ds/dt)² + q'·d²s/dt² of a joint q(s) can exceed the limit. It follows from the variances
    // and covariances of these factors within a window.
    const double by = reserve +
                      bend.second * (travel * change / 4 + squared(u * smoothing.window) / 12) +
                      bend.third * travel * (travel * u * 5 / 24 + squared(speed) / 6) +
                      bend.jump * squared(speed) * 2 / 3;
    limits[i].acceleration *= 1 - std::min(by, most_reduced);
  }
  return limits;
}

}  // namespace robcl::motion
