#include "robcl/motion/plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "robcl/motion/mean_limits.hpp"

namespace robcl::motion {
namespace {

// A motion that exceeds its limits by at most this factor counts as a motion that keeps them,
// because rounding errors are of this size.
constexpr double content = 1.0003;
constexpr int most_tries = 8;
// A motion that does not start at rest cannot be slowed at its start. If its initial speed makes it
// exceed the limits, each new try slows only the remaining motion. If the motion of a try lasts
// more than `most_slowed` times as long as the motion of the first try, planning fails.
constexpr double most_slowed = 3;
double just_kept(const Smoothing& smoothing) { return smoothing.on() ? 1.0008 : content; }

/// Returns the factor by which `law` must be slowed in each interval so that its set points keep
/// the limits of the joints. The factor is 1 where the set points already keep the limits.
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

/// Returns the fastest time law that keeps the limits everywhere. TimeLaw checks the limits at some
/// places only. Where the motion exceeds limits between these places, this function tightens the
/// limits there and tries again, several times.
///
/// If the last try still exceeds a limit, a time law that starts at rest is slowed. A time law that
/// starts in motion cannot be slowed: it may exceed its limits by the factor
/// `just_kept(smoothing)`, and beyond that this function returns nullopt. The limit of jerk is not
/// checked for it, because the path bends abruptly where one move goes over into the next.
std::optional<TimeLaw> fastest_law(const Path& path, const arm::ArmModel& model,
                                   const std::vector<IntervalLimits>& limits,
                                   const Smoothing& smoothing, const TimeLaw::Start& start) {
  const PathBounds bounds(path, model, limits);
  PathBounds tightened = bounds;
  const bool from_rest = start.at_rest();
  double longest = infinite;  // s
  for (int tries = 1;; ++tries) {
    auto law = TimeLaw::fastest(tightened, start, smoothing);
    if (!law && from_rest) law = TimeLaw::fastest(tightened, {}, {});
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
    // Tightening a limit at one place also slows the motion around that place. From the third try
    // on, the remaining excess is small and shrinks slowly, so the limit is tightened more than the
    // excess demands.
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
