#include "robcl/motion/pose_walk.hpp"

namespace robcl::motion {
namespace {

/// Fills the empty members of `kept` with those of `now`. A member is empty until the arm has left
/// the singularity at which the member is undefined.
void keep_what_is_known(arm::Configuration& kept, const arm::Configuration& now) {
  if (!kept.shoulder) kept.shoulder = now.shoulder;
  if (!kept.elbow) kept.elbow = now.elbow;
  if (!kept.wrist) kept.wrist = now.wrist;
}

}  // namespace

std::optional<arm::Failure> PoseWalk::step_to(const Frame& base_from_flange) {
  auto solution = inverse_.solve(base_from_flange, at_.joints, at_.kept);
  if (!solution) return solution.error();
  // The solver adds a whole turn to a joint that would pass its limit. The following loop removes
  // that turn.
  for (Eigen::Index axis = 0; axis < solution->size(); ++axis) {
    (*solution)[axis] = arm::nearest_angle((*solution)[axis], at_.joints[axis]);
  }
  if (auto outside = arm::first_outside(model_, *solution)) {
    outside->configuration = at_.kept;
    return *outside;
  }
  at_.joints = *std::move(solution);
  keep_what_is_known(at_.kept, inverse_.configuration(at_.joints));
  return std::nullopt;
}

}  // namespace robcl::motion
