#include "robcl/motion/move.hpp"

#include <algorithm>

namespace robcl::motion {
namespace {

std::vector<IntervalLimits> limits_at(const Move& move, const ToolLimits& limits,
                                      const Pace& pace) {
  IntervalLimits each;
  each.speed = pace.speed;
  each.acceleration = pace.acceleration;
  const ToolLimits tool = scaled(limits, pace);
  if (move.line) {
    const auto [way, turn] = tool_speed(move);
    const auto limit = [&each](double per_s, double speed, double acceleration) {
      if (per_s <= 0) return IntervalLimits::Tool{};
      each.cap = std::min(each.cap, squared(speed / per_s));
      return IntervalLimits::Tool{per_s, 0, acceleration};
    };
    each.way = limit(way, tool.speed, tool.acceleration);
    each.turn = limit(turn, tool.turn_speed, tool.turn_acceleration);
  }
  std::vector<IntervalLimits> all(move.path.intervals(), each);
  for (std::size_t i = 0; i < move.caps.size(); ++i) all[i].cap = move.caps[i];
  for (std::size_t i = 0; i < move.bends.size(); ++i) {
    all[i].way.per_x = move.bends[i].way;
    all[i].turn.per_x = move.bends[i].turn;
  }
  const WayAndTurn speed{tool.speed, tool.turn_speed};
  for (std::size_t i = 0; i < move.faster.size(); ++i) lower_cap(all[i], speed, move.faster[i]);
  return all;
}

}  // namespace

void lower_cap(IntervalLimits& limits, const WayAndTurn& speed, const WayAndTurn& faster) {
  const auto lower = [&](double of_tool, double per_s, double excess) {
    if (per_s > 0) limits.cap = std::min(limits.cap, squared(of_tool / (per_s + excess)));
  };
  lower(speed.way, limits.way.per_u, faster.way);
  lower(speed.turn, limits.turn.per_u, faster.turn);
}

WayAndTurn tool_speed(const Move& move) {
  if (!move.line) return {};
  constexpr double negligible = 1e-12;  // m or rad: a smaller movement sets no limit
  const auto per_s = [&](double whole) { return whole > negligible ? whole / move.duration() : 0; };
  return {per_s(move.line->length()), per_s(move.line->turn())};
}

ToolLimits scaled(const ToolLimits& limits, const Pace& pace) {
  const auto least = [](double limit, const std::optional<double>& asked) {
    return std::min(limit, asked.value_or(infinite));
  };
  return {.speed = least(limits.speed * pace.speed, pace.tool_speed),
          .acceleration = least(limits.acceleration * pace.acceleration, pace.tool_acceleration),
          .turn_speed = least(limits.turn_speed * pace.speed, pace.turn_speed),
          .turn_acceleration =
              least(limits.turn_acceleration * pace.acceleration, pace.turn_acceleration)};
}

std::vector<IntervalLimits> limits_of(const Move& move, const ToolLimits& limits) {
  return limits_at(move, limits, move.pace);
}

std::vector<IntervalLimits> braking_limits_of(const Move& move, const ToolLimits& limits) {
  return limits_at(move, limits, Pace{});
}

}  // namespace robcl::motion
