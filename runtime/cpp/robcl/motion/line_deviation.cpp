#include "robcl/motion/line_deviation.hpp"

#include <cmath>

namespace robcl::motion {
namespace {

/// The difference of two poses of the tool: the displacement along the axes of the base, in m, and
/// the rotation vector along the axes of the first pose, in rad.
struct Offset {
  Eigen::Vector3d way, turn;
};

Offset offset_between(const Frame& from, const Frame& to) {
  const Eigen::AngleAxisd turn(from.orientation().inverse() * to.orientation());
  return {to.position() - from.position(), turn.angle() * turn.axis()};
}

}  // namespace

WayAndTurn LineDeviation::bend(double step) const {
  constexpr double of_even = 32;  // second derivative of 16 t²(1 - t)² at a knot
  constexpr double of_odd = 64;   // second derivative of 32/3 t(1 - t)(1 - 2t) at a knot
  const double per_s = 1 / (step * step);
  return {(of_even * even.way + of_odd * odd.way) * per_s,
          (of_even * even.turn + of_odd * odd.turn) * per_s};
}

/// At the fraction t of the interval, the even part of the deviation is proportional to t²(1 - t)²,
/// and the odd part to t(1 - t)(1 - 2t). The even part is the deviation that remains if the slopes
/// at the knots are exact. The odd part comes from errors of the slopes. Both parts follow from the
/// deviations at t = 1/4 and at t = 3/4.
LineDeviation deviation_in(const Path& path, std::size_t interval, const LineOnPath& line,
                           const arm::Kinematics& forward) {
  const double begin = path.place(interval), step = path.step(interval);
  const auto offset_at = [&](double s) {
    const Frame tool = forward.base_from_flange(path.position(s)) * line.flange_from_tool;
    return offset_between(line.at(s), tool);
  };
  const Offset first = offset_at(begin + step / 4), last = offset_at(begin + 3 * step / 4);
  constexpr double in_middle = 16.0 / 9;  // value of t²(1 - t)² at 1/2, divided by its value at 1/4
  const Offset even{in_middle / 2 * (first.way + last.way),
                    in_middle / 2 * (first.turn + last.turn)};
  const Offset odd{(first.way - last.way) / 2, (first.turn - last.turn) / 2};
  const Offset ahead = offset_between(line.at(begin), line.at(begin + step));
  constexpr double of_even = 3.0792;   // 16/(3√3): the greatest slope of 16 t²(1 - t)²
  constexpr double of_odd = 32.0 / 3;  // the greatest slope of 32/3 t(1 - t)(1 - 2t)
  const auto faster = [&](const Eigen::Vector3d& direction, const Eigen::Vector3d& of_even_part,
                          const Eigen::Vector3d& of_odd_part) {
    const Eigen::Vector3d along = direction.stableNormalized();
    return (of_even * std::abs(along.dot(of_even_part)) +
            of_odd * std::abs(along.dot(of_odd_part))) /
           step;
  };
  return {{even.way.norm(), even.turn.norm()},
          {odd.way.norm(), odd.turn.norm()},
          {faster(ahead.way, even.way, odd.way), faster(ahead.turn, even.turn, odd.turn)}};
}

}  // namespace robcl::motion
