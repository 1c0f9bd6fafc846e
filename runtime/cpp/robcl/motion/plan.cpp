#include "robcl/motion/plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "robcl/motion/mean_limits.hpp"

namespace robcl::motion {
namespace {

// A motion that is too fast by at most this factor counts as one that keeps its limits: the rest is
// rounding.
constexpr double content = 1.0003;
constexpr int most_tries = 8;
// A motion that does not start at rest cannot be slowed before the last knot of its start. What it
// exceeds because of its speed there would make the rest of it slower with each try. A motion that
// takes more than this many times the duration of the first try is given up.
constexpr double most_slowed = 3;
double just_kept(const Smoothing& smoothing) { return smoothing.on() ? 1.0008 : content; }

/// Returns the factor by which `law` must be slowed in each interval so that its set points keep
/// the limits of the joints; 1 where they keep them.
std::vector<double> excess_of(const TimeLaw& law, const Path& path, const arm::ArmModel& model,
                              const std::vector<IntervalLimits>& limits, const PathBounds& bounds,
                              std::size_t from_knot, const Smoothing& smoothing) {
  if (smoothing.on()) return excess_of_mean(path, model, limits, law, from_knot, smoothing);
  std::vector<double> factors(path.intervals(), 1);
  for (std::size_t i = from_knot; i < path.intervals(); ++i) {
    factors[i] = bounds.excess(i, law.squares()[i], law.acceleration(i));
  }
  return factors;
}

/// Returns the fastest time law that keeps the limits everywhere. The time law checks the limits at
/// some places only; where they are exceeded between these places, they are tightened there, and
/// the time law is computed again. A time law from rest that still exceeds a limit at the end is
/// slowed. A time law that does not start at rest cannot be slowed. It may exceed the limit of jerk
/// where one move goes over into the next, because the path itself bends abruptly there, and it
/// uses a part of the reserve of excess_of_mean.
std::optional<TimeLaw> fastest_law(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits,
                                   const Smoothing& smoothing, const TimeLaw::Start& start) {
  const PathBounds bounds(path, model, limits);
  PathBounds tightened = bounds;
  const bool from_rest = start.at_rest();
  double longest = infinite;  // s
  for (int tries = 1;; ++tries) {
    auto law = TimeLaw::fastest_from(tightened, start, smoothing);
    if (!law && from_rest) law = TimeLaw::fastest(tightened);
    if (!law) return std::nullopt;
    if (tries == 1) longest = most_slowed * law->duration();
    if (!from_rest && law->duration() > longest) return std::nullopt;
    auto factors = excess_of(*law, path, model, limits, bounds, start.knot(), smoothing);
    if (from_rest) {
      const auto of_jerk = law->change_excess(bounds, smoothing);
      std::ranges::transform(factors, of_jerk, factors.begin(),
                             [](double one, double other) { return std::max(one, other); });
    }
    const double worst = std::ranges::max(factors);
    if (worst <= content) return law;
    if (tries == most_tries && from_rest) return law->slowed(worst);
    if (tries == most_tries) return worst <= just_kept(smoothing) ? law : std::nullopt;
    // The motion is also slowed around the place. A remaining factor is small, but does not go
    // away.
    const double exponent = tries <= 2 ? 1 : 3;
    for (std::size_t i = start.knot(); i < factors.size(); ++i) {
      if (factors[i] > 1) tightened.tighten(i, std::pow(factors[i], exponent));
    }
  }
}

}  // namespace

std::optional<Plan> fastest_plan(Path path, const arm::ArmModel& model, CourseLimits limits,
                                 const Smoothing& smoothing, const TimeLaw::Start& start) {
  auto law = fastest_law(path, model, limits.moving, smoothing, start);
  if (!law) return std::nullopt;
  if (smoothing.on()) {
    limits.braking = narrowed(path, model, std::move(limits.braking), *law, smoothing);
  }
  PathBounds braking(path, model, limits.braking);
  return Plan{std::move(path), std::move(braking), *std::move(law), smoothing, start.knot()};
}

}  // namespace robcl::motion
