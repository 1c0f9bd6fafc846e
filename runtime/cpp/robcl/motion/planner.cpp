#include "robcl/motion/planner.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace robcl::motion {
namespace {

using arm::Failure;
using arm::JointLimit;
using arm::OutOfReach;

constexpr int joint_move_knots = 100;
constexpr double no_move = 1e-9;  // rad or m: a smaller move counts as none

double square_of(double value) { return value * value; }

/// Returns the factor by which `law` must be slowed so that the joint limits are also kept between
/// the places that PathBounds::over_interval checks. Where the path of a joint is steep, for
/// example when an arm starts stretched, an interval between two knots may last many control
/// cycles.
double excess(const PathBounds& bounds, const TimeLaw& law) {
  double factor = 1;
  for (std::size_t i = 0; i < bounds.intervals(); ++i) {
    const double x = square_of(law.speed(i)), after = square_of(law.speed(i + 1));
    factor = std::max(factor, bounds.excess(i, x, (after - x) / (2 * bounds.step())));
  }
  return factor;
}

/// Makes the plan of a move from `bounds`. `limit_tool` adds the limits of the tool to the limits
/// for braking.
template <class LimitTool>
Plan fastest(Path path, const PathBounds& bounds, const arm::ArmModel& model,
             LimitTool limit_tool) {
  const TimeLaw law = TimeLaw::fastest(bounds);
  PathBounds braking(path, model, {});
  limit_tool(braking);
  return {std::move(path), std::move(braking), law.slowed(excess(bounds, law))};
}

Plan standing(const arm::ArmModel& model, const JointValues& at) {
  Path path({at, at});
  PathBounds braking(path, model, {});
  return {std::move(path), std::move(braking), TimeLaw::standing()};
}

}  // namespace

Planner::Planner(const arm::ArmModel& model, const ToolLimits& limits)
    : model_(model), limits_(limits), forward_(model), inverse_(arm::make_inverse(model)) {}

Frame Planner::base_from_tool(const JointValues& joints, const Frame& flange_from_tool) {
  return forward_.base_from_flange(joints) * flange_from_tool;
}

std::optional<OutOfReach> Planner::absurd(const Frame& base_from_goal) const {
  const double away = base_from_goal.position().norm();
  if (away <= 3 * model_.reach()) return std::nullopt;
  std::ostringstream text;
  text << std::setprecision(4) << "the goal is " << away << " m from the base, the arm reaches "
       << model_.reach() << " m: is the goal in millimetres?";
  return OutOfReach{text.str()};
}

tl::expected<Plan, Failure> Planner::joints(const JointValues& from, const JointValues& to,
                                            const Pace& pace, const Frame& flange_from_tool) {
  if (const auto outside = arm::first_outside(model_, to)) return tl::unexpected(*outside);
  if ((to - from).cwiseAbs().maxCoeff() < no_move) return standing(model_, from);
  std::vector<JointValues> knots;
  for (int i = 0; i <= joint_move_knots; ++i) {
    knots.push_back(from + (to - from) * (static_cast<double>(i) / joint_move_knots));
  }
  knots.back() = to;
  Path path(std::move(knots));
  PathBounds bounds(path, model_, pace);
  if (pace.tool_speed || pace.turn_speed) {
    Frame before = base_from_tool(path.knot(0), flange_from_tool);
    for (std::size_t i = 1; i <= path.intervals(); ++i) {
      const Frame here = base_from_tool(path.knot(i), flange_from_tool);
      const double length = distance(before, here) / path.step();
      const double turn = angle(before, here) / path.step();
      for (const std::size_t knot : {i - 1, i}) {
        if (pace.tool_speed && length > 0) bounds.cap(knot, std::pow(*pace.tool_speed / length, 2));
        if (pace.turn_speed && turn > 0) bounds.cap(knot, std::pow(*pace.turn_speed / turn, 2));
      }
      before = here;
    }
  }
  return fastest(std::move(path), bounds, model_, [](PathBounds&) {});
}

tl::expected<Plan, Failure> Planner::joints_to(const JointValues& from, const Frame& base_from_goal,
                                               const Frame& flange_from_tool, const Pace& pace,
                                               const std::optional<arm::Configuration>& wanted) {
  if (auto far = absurd(base_from_goal)) return tl::unexpected(*far);
  const Frame base_from_flange = base_from_goal * flange_from_tool.inverse();
  const arm::Configuration present = inverse_->configuration(from);
  const auto to = inverse_->solve(base_from_flange, from, wanted.value_or(present));
  if (to) return joints(from, *to, pace, flange_from_tool);
  if (!wanted) {
    if (const auto other = inverse_->solve(base_from_flange, from)) {
      std::ostringstream text;
      text << "the goal cannot be reached as " << present << ", only in another configuration such "
           << "as " << inverse_->configuration(*other) << ": ask for it, or for any";
      return tl::unexpected(OutOfReach{text.str()});
    }
  }
  return tl::unexpected(to.error());
}

tl::expected<Plan, Failure> Planner::straight(const JointValues& from, const Frame& base_from_goal,
                                              const Frame& flange_from_tool, const Pace& pace) {
  if (auto far = absurd(base_from_goal)) return tl::unexpected(*far);
  const Frame tool_from_flange = flange_from_tool.inverse();
  if (const auto there = inverse_->solve(base_from_goal * tool_from_flange, from); !there) {
    return tl::unexpected(there.error());
  }
  const Frame start = base_from_tool(from, flange_from_tool);
  if (near(start, base_from_goal, no_move, no_move)) return standing(model_, from);
  const Line line(start, base_from_goal);
  auto path = path_of_line(from, line, tool_from_flange);
  if (!path) return tl::unexpected(path.error());
  PathBounds bounds(*path, model_, pace);
  bounds.add_tool(line.length(), line.turn(), limits_, pace);
  return fastest(std::move(*path), bounds, model_, [&](PathBounds& braking) {
    braking.add_tool(line.length(), line.turn(), limits_, {});
  });
}

}  // namespace robcl::motion
