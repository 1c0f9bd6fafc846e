#include "robcl/arm/numeric_inverse.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace robcl::arm {
namespace {

// Returns the weights of the parts of a pose error: an error of 1 rad counts as much as an error of
// 0.1 m.
Eigen::Matrix<double, 6, 1> weights() {
  Eigen::Matrix<double, 6, 1> each;
  each << 1, 1, 1, 0.1, 0.1, 0.1;
  return each;
}

constexpr double solver_error = 1e-8;
constexpr int solver_steps = 500;
// An arm with fewer than six joints reaches only some of the poses near a pose that it reaches, so
// the rounding of a goal makes the goal unreachable. Therefore the flange of such an arm may miss
// its goal by this distance in m and this angle in rad.
constexpr double accuracy_of_few_joints = 1e-6;
constexpr Eigen::Index joints_for_every_pose = 6;

}  // namespace

NumericInverse::NumericInverse(const ArmModel& model)
    : model_(model),
      local_(model),
      chain_(model.chain()),
      solver_(chain_, weights(), solver_error, solver_steps) {}

JointValues NumericInverse::start(int attempt, const JointValues& reference) const {
  if (attempt == 0) return reference;
  JointValues joints(reference.size());
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const JointLimits& limits = model_.limits()[static_cast<std::size_t>(i)];
    const double lower = std::max(limits.lower, -std::numbers::pi);
    const double upper = std::min(limits.upper, std::numbers::pi);
    // The start points are multiples of irrational numbers, which fill the joint ranges evenly
    // (Weyl's sequence).
    const double step = std::sqrt(static_cast<double>(2 + 3 * i));
    joints[i] = lower + (upper - lower) * std::fmod(attempt * step, 1.0);
  }
  return joints;
}

/// Returns the solution near `joints`; nullopt if there is none.
std::optional<JointValues> NumericInverse::refined(const Frame& base_from_flange,
                                                   JointValues joints) const {
  const auto known = local_.at(joints);
  auto solution = local_.solve(base_from_flange, known);
  if (!solution && joints.size() < joints_for_every_pose) {
    solution = local_.solve(base_from_flange, known, accuracy_of_few_joints);
  }
  if (!solution) return std::nullopt;
  return solution->joints;
}

tl::expected<JointValues, Failure> NumericInverse::solve(const Frame& base_from_flange,
                                                         const JointValues& reference,
                                                         const Configuration& wanted) {
  if (wanted != Configuration{}) {
    return tl::unexpected(OutOfReach{"this arm has no configurations to choose from"});
  }
  if (const auto near = refined(base_from_flange, reference);
      near && !first_outside(model_, *near)) {
    return *near;
  }
  const KDL::Frame goal = to_kdl(base_from_flange);
  KDL::JntArray from(static_cast<unsigned>(reference.size()));
  KDL::JntArray answer(from.rows());
  std::optional<JointLimit> nearest_miss;
  for (int attempt = 0; attempt < starts; ++attempt) {
    from.data = start(attempt, reference);
    if (solver_.CartToJnt(from, goal, answer) != KDL::SolverI::E_NOERROR) continue;
    auto found = refined(base_from_flange, answer.data);
    if (!found) continue;
    JointValues& joints = *found;
    for (Eigen::Index i = 0; i < joints.size(); ++i) {
      joints[i] =
          nearest_turn(joints[i], reference[i], model_.limits()[static_cast<std::size_t>(i)]);
    }
    const auto outside = first_outside(model_, joints);
    if (!outside) return joints;
    if (!nearest_miss) nearest_miss = outside;
  }
  if (nearest_miss) return tl::unexpected(*nearest_miss);
  return tl::unexpected(OutOfReach{why_out_of_reach(base_from_flange)});
}

std::string NumericInverse::why_out_of_reach(const Frame& base_from_flange) const {
  const double away = base_from_flange.position().norm();
  const Eigen::Index joints = chain_.getNrOfJoints();
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (joints < joints_for_every_pose && away <= model_.reach()) {
    text << "an arm with " << joints
         << " joints reaches only some orientations; no joint positions were found for this one, "
         << "at " << in_mm(away) << " mm from the base: give a pose that the arm has had";
  } else {
    text << "no joint positions found for a flange " << in_mm(away) << " mm from the base (reach "
         << in_mm(model_.reach()) << " mm)";
  }
  return text.str();
}

}  // namespace robcl::arm
