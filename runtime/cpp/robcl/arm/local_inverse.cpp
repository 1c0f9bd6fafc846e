#include "robcl/arm/local_inverse.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::arm {
namespace {

// The square of the damping factor. The factor is small, because damping slows the convergence.
// Near a singularity, a search with such a small factor may leave the range `furthest`, and then
// fails.
constexpr double damping = 1e-10;

}  // namespace

PoseStep step_between(const Frame& from, const Frame& to) {
  PoseStep step;
  step << to.position() - from.position(),
      rotation_vector(to.orientation() * from.orientation().conjugate());
  return step;
}

DampedInverse::DampedInverse(const Jacobian& jacobian)
    : jacobian_(jacobian), square_(jacobian.lazyProduct(jacobian.transpose())) {
  square_.diagonal().array() += damping;
  root_.compute(square_);
}

/// Estimates the least eigenvalue of J·Jᵀ, where J is the Jacobian matrix, by the least pivot of
/// the decomposition of J·Jᵀ. This pivot is never below the eigenvalue. An arm with fewer than six
/// joints can never move its tool in every direction. For such an arm, the function takes Jᵀ·J
/// instead, which leaves out the impossible directions.
double DampedInverse::singularity_distance() const {
  if (jacobian_.cols() >= square_.rows()) {
    return std::sqrt(std::max(square_.ldlt().vectorD().minCoeff() - damping, 0.0));
  }
  using SmallSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  const SmallSquare square = jacobian_.transpose().lazyProduct(jacobian_);
  return std::sqrt(std::max(square.ldlt().vectorD().minCoeff(), 0.0));
}

LocalInverse::Solution LocalInverse::at(const JointValues& joints) const {
  const Kinematics::Place place = forward_.place(joints);
  return {joints, place.base_from_tip, DampedInverse(place.jacobian)};
}

std::optional<LocalInverse::Solution> LocalInverse::solve(const Frame& base_from_tool,
                                                          const Solution& known,
                                                          double tolerance) const {
  Solution here = known;
  for (int i = 0; i < most_steps; ++i) {
    const PoseStep away = step_between(here.base_from_tool, base_from_tool);
    if (away.cwiseAbs().maxCoeff() <= tolerance) return here;
    const JointValues next = here.joints + here.inverse.joint_speeds(away);
    if (!((next - known.joints).cwiseAbs().maxCoeff() <= furthest)) return std::nullopt;
    here = at(next);
  }
  return std::nullopt;
}

}  // namespace robcl::arm
