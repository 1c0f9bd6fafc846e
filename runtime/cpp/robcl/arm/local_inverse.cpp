#include "robcl/arm/local_inverse.hpp"

#include <algorithm>
#include <cmath>

namespace robcl::arm {
namespace {

// The square of the damping factor. It is small, because it slows the convergence; beside a
// singularity the search then leaves `furthest`.
constexpr double damping = 1e-10;

}  // namespace

Eigen::Vector3d rotation_vector(Eigen::Quaterniond turn) {
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();  // of half the angle
  if (sine == 0) return Eigen::Vector3d::Zero();
  return turn.vec() * (2 * std::atan2(sine, turn.w()) / sine);
}

PoseStep step_between(const Frame& from, const Frame& to) {
  PoseStep step;
  step << to.position() - from.position(),
      rotation_vector(to.orientation() * from.orientation().conjugate());
  return step;
}

DampedInverse::DampedInverse(const Jacobian& jacobian) : jacobian_(jacobian) {
  Eigen::Matrix<double, 6, 6> square = jacobian * jacobian.transpose();
  square.diagonal().array() += damping;
  square_.compute(square);
}

/// The least of the pivots of a symmetric matrix is at least its least eigenvalue.
double DampedInverse::singularity_distance() const {
  return std::sqrt(std::max(square_.vectorD().minCoeff() - damping, 0.0));
}

std::optional<LocalInverse::Solution> LocalInverse::solve(const Frame& base_from_flange,
                                                          const JointValues& known) {
  JointValues joints = known;
  for (int i = 0; i < most_steps; ++i) {
    const Kinematics::Place place = forward_.place(joints);
    const PoseStep away = step_between(place.base_from_flange, base_from_flange);
    if (away.cwiseAbs().maxCoeff() <= accuracy) return Solution{joints, place};
    joints += DampedInverse(place.jacobian).joint_speeds(away);
    if (!((joints - known).cwiseAbs().maxCoeff() <= furthest)) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace robcl::arm
