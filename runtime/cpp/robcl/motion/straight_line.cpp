// Computes the path of the joints for a straight line of the tool, by solving the inverse
// kinematics at every knot.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "robcl/motion/line.hpp"
#include "robcl/motion/planner.hpp"

namespace robcl::motion {
namespace {

using arm::Failure;
using arm::JointLimit;
using arm::OutOfReach;
using arm::Singular;

constexpr double line_step = mm(1);     // longest distance of the tool between two knots
constexpr double turn_step = deg(0.2);  // largest turn of the tool between two knots
constexpr double joint_step = 0.03;     // rad per joint between two knots; else more knots
constexpr double joint_jump = 0.1;      // rad per joint between the closest knots; else fail
constexpr std::size_t closer = 8;       // the number of knots grows at most by this factor
constexpr std::size_t fewest = 50, most = 4000;

Failure with_place(Failure failure, const std::string& where) {
  if (auto* reach = std::get_if<OutOfReach>(&failure)) {
    reach->reason = where + ": " + reach->reason;
  }
  return failure;
}

/// Fills the empty members of `kept` with those of `now`. A member is empty until the arm has left
/// the singularity at which the member is undefined.
void keep_what_is_known(arm::Configuration& kept, const arm::Configuration& now) {
  if (!kept.shoulder) kept.shoulder = now.shoulder;
  if (!kept.elbow) kept.elbow = now.elbow;
  if (!kept.wrist) kept.wrist = now.wrist;
}

/// Returns whether the arm is at no singularity, where a joint may have any position.
bool well_defined(const arm::Configuration& configuration) {
  return configuration.shoulder && configuration.elbow && configuration.wrist;
}

struct Step {
  std::size_t knot = 0;  // index of the knot at the end of the step
  Eigen::Index axis = 0;
  double change = 0;  // rad
};

/// Returns the greatest step of a joint between two successive knots.
Step greatest_step(const std::vector<JointValues>& knots) {
  Step greatest;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    Eigen::Index axis = 0;
    const double change = (knots[i] - knots[i - 1]).cwiseAbs().maxCoeff(&axis);
    if (change > greatest.change) greatest = {i, axis, change};
  }
  return greatest;
}

}  // namespace

tl::expected<std::vector<JointValues>, Failure> Planner::knots_of_line(
    const JointValues& from, const Line& line, const Frame& tool_from_flange, std::size_t intervals,
    const std::vector<JointValues>& coarse) {
  arm::Configuration kept = inverse_->configuration(from);
  std::vector<JointValues> knots{from};
  knots.reserve(intervals + 1);
  for (std::size_t i = 1; i <= intervals; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(intervals);
    const JointValues& before = knots.back();
    JointValues steady;
    if (!coarse.empty() && i % 2 == 0 && well_defined(inverse_->configuration(coarse[i / 2]))) {
      steady = coarse[i / 2];
    } else {
      auto solution = inverse_->solve(line.at(part) * tool_from_flange, before, kept);
      if (!solution) return tl::unexpected(with_place(solution.error(), line.place(part)));
      steady = std::move(*solution);
    }
    // The solver adds a whole turn to a joint that would pass its limit. The following loop removes
    // that turn.
    for (Eigen::Index axis = 0; axis < steady.size(); ++axis) {
      steady[axis] = arm::nearest_angle(steady[axis], before[axis]);
    }
    if (const auto outside = arm::first_outside(model_, steady)) return tl::unexpected(*outside);
    knots.push_back(steady);
    keep_what_is_known(kept, inverse_->configuration(steady));
  }
  return knots;
}

tl::expected<Path, Failure> Planner::path_of_line(const JointValues& from, const Line& line,
                                                  const Frame& tool_from_flange) {
  const double steps = std::ceil(std::max(line.length() / line_step, line.turn() / turn_step));
  const auto widest = std::clamp(static_cast<std::size_t>(std::max(steps, 1.0)), fewest, most);
  std::vector<JointValues> coarse;
  for (std::size_t intervals = widest;; intervals *= 2) {
    auto knots = knots_of_line(from, line, tool_from_flange, intervals, coarse);
    if (!knots) return tl::unexpected(knots.error());
    const Step step = greatest_step(*knots);
    const bool closest = intervals >= closer * widest;
    if (step.change <= (closest ? joint_jump : joint_step)) return Path(std::move(*knots));
    if (!closest) {
      coarse = std::move(*knots);
      continue;
    }
    const double each = 1.0 / static_cast<double>(intervals);
    std::ostringstream text;
    text << line.place(static_cast<double>(step.knot) * each) << " joint " << step.axis + 1
         << " would have to turn " << std::fixed << std::setprecision(1) << in_deg(step.change)
         << " deg within " << std::setprecision(2);
    if (line.length() > 0) {
      text << in_mm(line.length() * each) << " mm";
    } else {
      text << in_deg(line.turn() * each) << " deg";
    }
    text << "; avoid the singularity or use a joint move";
    return tl::unexpected(Singular{text.str()});
  }
}

}  // namespace robcl::motion
