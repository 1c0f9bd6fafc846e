#include "robcl/motion/planner.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include "robcl/motion/line_path.hpp"

namespace robcl::motion {
namespace {

using arm::Failure;
using arm::JointLimit;
using arm::OutOfReach;

constexpr int joint_move_knots = 100;
constexpr double no_move = 1e-9;  // rad or m: a smaller move counts as none

Move standing(const JointValues& at, const Pace& pace, const Frame& flange_from_tool) {
  return {Path({{0, 1}, {at, at}}), pace, std::nullopt, flange_from_tool, true};
}

}  // namespace

Planner::Planner(const arm::ArmModel& model, const ToolLimits& limits, const Smoothing& smoothing)
    : model_(model),
      limits_(limits),
      smoothing_(smoothing),
      forward_(model),
      inverse_(arm::make_inverse(model)) {}

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

tl::expected<Plan, Failure> Planner::plan_of(const tl::expected<Move, Failure>& move) const {
  if (!move) return tl::unexpected(move.error());
  return plan(*move);
}

Plan Planner::plan(const Move& move) const {
  CourseLimits limits{limits_of(move, limits_), braking_limits_of(move, limits_)};
  if (move.stands) {
    return {move.path, {move.path, model_, limits.braking}, TimeLaw::standing(), smoothing_};
  }
  auto plan = fastest_plan(move.path, model_, std::move(limits), smoothing_);
  if (!plan) {
    throw std::runtime_error(
        "the limits of the joints and of the tool are so low that the arm would stop before the "
        "goal");
  }
  return *std::move(plan);
}

tl::expected<Move, Failure> Planner::joint_move(const JointValues& from, const JointValues& to,
                                                const Pace& pace, const Frame& flange_from_tool) {
  if (const auto outside = arm::first_outside(model_, to)) return tl::unexpected(*outside);
  if ((to - from).cwiseAbs().maxCoeff() < no_move) return standing(from, pace, flange_from_tool);
  const double duration = arm::travel_time(model_, from, to) / pace.speed;
  Path::Knots knots;
  for (int i = 0; i <= joint_move_knots; ++i) {
    const double part = static_cast<double>(i) / joint_move_knots;
    knots.add(part * duration, from + (to - from) * part);
  }
  knots.joints.back() = to;
  Path path(std::move(knots));
  auto caps = caps_of_tool(path, pace, flange_from_tool);
  return Move{std::move(path), pace, std::nullopt, flange_from_tool, false, std::move(caps)};
}

/// Returns, for each interval, the greatest (ds/dt)² at which the tool keeps the speeds of `pace`;
/// an empty vector if `pace` limits no speed of the tool.
std::vector<double> Planner::caps_of_tool(const Path& path, const Pace& pace,
                                          const Frame& flange_from_tool) {
  std::vector<double> caps;
  if (!pace.tool_speed && !pace.turn_speed) return caps;
  Frame before = base_from_tool(path.knot(0), flange_from_tool);
  for (std::size_t i = 0; i < path.intervals(); ++i) {
    const Frame after = base_from_tool(path.knot(i + 1), flange_from_tool);
    const double way = distance(before, after) / path.step(i);
    const double turn = angle(before, after) / path.step(i);
    double cap = infinite;
    if (pace.tool_speed && way > 0) cap = std::min(cap, squared(*pace.tool_speed / way));
    if (pace.turn_speed && turn > 0) cap = std::min(cap, squared(*pace.turn_speed / turn));
    caps.push_back(cap);
    before = after;
  }
  return caps;
}

tl::expected<Move, Failure> Planner::joint_move_to(
    const JointValues& from, const Frame& base_from_goal, const Frame& flange_from_tool,
    const Pace& pace, const std::optional<arm::Configuration>& wanted) {
  if (auto far = absurd(base_from_goal)) return tl::unexpected(*far);
  const Frame base_from_flange = base_from_goal * flange_from_tool.inverse();
  const arm::Configuration present = inverse_->configuration(from);
  const auto to = inverse_->solve(base_from_flange, from, wanted.value_or(present));
  if (to) return joint_move(from, *to, pace, flange_from_tool);
  if (!wanted) {
    if (const auto other = inverse_->solve(base_from_flange, from)) {
      std::ostringstream text;
      text << "the goal cannot be reached as " << present << ", only in another configuration such "
           << "as " << inverse_->configuration(*other)
           << "; request that configuration, or allow any configuration";
      return tl::unexpected(OutOfReach{text.str()});
    }
  }
  return tl::unexpected(to.error());
}

tl::expected<Move, Failure> Planner::straight_move(const JointValues& from,
                                                   const Frame& base_from_goal,
                                                   const Frame& flange_from_tool,
                                                   const Pace& pace) {
  if (auto far = absurd(base_from_goal)) return tl::unexpected(*far);
  const Frame tool_from_flange = flange_from_tool.inverse();
  if (const auto there = inverse_->solve(base_from_goal * tool_from_flange, from); !there) {
    return tl::unexpected(there.error());
  }
  const Frame start = base_from_tool(from, flange_from_tool);
  if (near(start, base_from_goal, no_move, no_move)) {
    return standing(from, pace, flange_from_tool);
  }
  const Line line(start, base_from_goal);
  const ToolLimits tool = scaled(limits_, pace);
  const double duration = std::max(line.length() / tool.speed, line.turn() / tool.turn_speed);
  auto made =
      path_of_line(model_, forward_, *inverse_, from, {line, flange_from_tool, 0, duration});
  if (!made) return tl::unexpected(made.error());
  Move move{std::move(made->path), pace, line, flange_from_tool};
  move.most_turned = made->most_turned;
  move.bends = std::move(made->bends);
  move.faster = std::move(made->faster);
  return move;
}

}  // namespace robcl::motion
