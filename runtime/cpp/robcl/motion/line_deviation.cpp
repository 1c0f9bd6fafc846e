#include "robcl/motion/line_deviation.hpp"

namespace robcl::motion {
namespace {

/// The position of the tool, in m, and its rotation vector, in rad, both seen from its line.
struct Offset {
  Eigen::Vector3d way, turn;
};

}  // namespace

WayAndTurn LineDeviation::bend(double step) const {
  constexpr double of_even = 32;  // of 16 t²(1 - t)², which is 1 in the middle
  constexpr double of_odd = 64;   // of 32/3 t(1 - t)(1 - 2t), which is 1 at 1/4
  const double per_s = 1 / (step * step);
  return {(of_even * even.way + of_odd * odd.way) * per_s,
          (of_even * even.turn + of_odd * odd.turn) * per_s};
}

/// The even part is in proportion to t²(1 - t)², which exact slopes at the knots leave. The odd
/// part is in proportion to t(1 - t)(1 - 2t), where the slopes themselves are not exact. Two places
/// tell both parts.
LineDeviation deviation_in(const Path& path, std::size_t interval, const LineOnPath& line,
                           const arm::Kinematics& forward) {
  const double begin = path.place(interval), step = path.step(interval);
  const auto offset_at = [&](double s) {
    const Frame there = line.at(s);
    const Frame tool = forward.base_from_flange(path.position(s)) * line.flange_from_tool;
    const Eigen::AngleAxisd turn(there.orientation().inverse() * tool.orientation());
    return Offset{tool.position() - there.position(), turn.angle() * turn.axis()};
  };
  const Offset first = offset_at(begin + step / 4), last = offset_at(begin + 3 * step / 4);
  constexpr double in_middle = 16.0 / 9;  // of t²(1 - t)², compared with its value at 1/4
  return {{in_middle / 2 * (first.way + last.way).norm(),
           in_middle / 2 * (first.turn + last.turn).norm()},
          {(first.way - last.way).norm() / 2, (first.turn - last.turn).norm() / 2}};
}

}  // namespace robcl::motion
