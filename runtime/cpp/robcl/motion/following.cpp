#include "robcl/motion/following.hpp"

#include <utility>

#include "robcl/arm/local_inverse.hpp"

namespace robcl::motion {
namespace {

constexpr double limit_rounding = 1e-9;  // m or rad

}  // namespace

Following::Following(const arm::ArmModel& model, const JointValues& start,
                     const Frame& flange_from_tool, CorrectionAxes axes, const FollowLimits& limits,
                     std::shared_ptr<CorrectionSource> source)
    : start_(start),
      axes_(axes),
      limits_(limits),
      source_(std::move(source)),
      lead_(model, start, flange_from_tool, limits.tool),
      origin_(lead_.pose()),
      target_(origin_),
      joints_(model.limits(), start) {}

JointValues Following::advance(double seconds) {
  if (!stopping_) take_corrections();
  const auto target = stopping_ ? std::nullopt : std::optional(target_);
  const Hold hold = lead_.move(target, override_, joints_, seconds);
  joints_.follow(lead_.joints(), seconds);
  report(hold);
  return joints_.joints();
}

void Following::take_corrections() {
  while (const auto correction = source_->next()) apply(*correction);
  if (!source_->expired()) return;
  expired_ = true;
  stopping_ = true;
}

void Following::apply(const Frame& correction) {
  const Frame target = axes_ == CorrectionAxes::Tool
                           ? target_ * correction
                           : Frame(target_.position() + correction.position(),
                                   correction.orientation() * target_.orientation());
  // A correction of more than 1e300 m makes the target NaN, which these comparisons refuse, too.
  const bool inside = distance(origin_, target) <= limits_.distance + limit_rounding &&
                      angle(origin_, target) <= limits_.angle + limit_rounding;
  if (!inside) {
    ++state_.dropped;
    return;
  }
  target_ = target;
  ++state_.applied;
}

void Following::rest() {
  joints_.rest();
  lead_.put_at(joints_.joints());
}

void Following::report(const Hold& hold) {
  const arm::PoseStep left = arm::step_between(lead_.pose(), target_);
  state_.distance_left = left.head<3>().norm();
  state_.angle_left = left.tail<3>().norm();
  state_.hold = hold;
  source_->report(state_);
}

}  // namespace robcl::motion
