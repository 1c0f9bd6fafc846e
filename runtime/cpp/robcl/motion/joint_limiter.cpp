#include "robcl/motion/joint_limiter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "robcl/motion/braking.hpp"

namespace robcl::motion {
namespace {

constexpr double rounding = 1e-12;  // rad

}  // namespace

JointLimiter::JointLimiter(std::vector<arm::JointLimits> limits, const JointValues& start)
    : limits_(std::move(limits)),
      joints_(start),
      target_(start),
      speeds_(JointValues::Zero(start.size())) {}

const JointValues& JointLimiter::follow(const JointValues& target, double cycle) {
  for (Eigen::Index axis = 0; axis < joints_.size(); ++axis) {
    const arm::JointLimits& limits = limits_[static_cast<std::size_t>(axis)];
    const double wanted = std::isfinite(target[axis]) ? target[axis] : joints_[axis];
    // Rounding may put a target outside the limits, where the joint would never arrive.
    const double inside = std::clamp(wanted, limits.lower, limits.upper);
    follow(axis, inside, cycle);
    target_[axis] = inside;
  }
  return joints_;
}

/// Moves one joint for one cycle. The speed of each cycle is one from which the joint can stop
/// before its limit. Therefore the speed after one more cycle of braking is always allowed, and
/// `slowest` never exceeds `fastest`.
void JointLimiter::follow(Eigen::Index axis, double target, double cycle) {
  const arm::JointLimits& limits = limits_[static_cast<std::size_t>(axis)];
  const double here = joints_[axis], now = speeds_[axis];
  const double change = limits.acceleration * cycle;
  const auto room = [&](double distance) {
    return stopping_speed(std::max(distance, 0.0), limits.acceleration, cycle);
  };
  const double fastest = std::min({limits.speed, now + change, room(limits.upper - here)});
  const double slowest = std::max({-limits.speed, now - change, -room(here - limits.lower)});

  const double behind = target_[axis] - here;
  const double catching_up = std::copysign(std::min(room(std::abs(behind)), limits.speed), behind);
  const double wanted = (target - target_[axis]) / cycle + (behind != 0 ? catching_up : 0);
  const double speed = std::max(slowest, std::min(wanted, fastest));
  const double next = here + speed * cycle;
  const bool there = std::abs(next - target) <= rounding;
  joints_[axis] = there ? target : next;
  speeds_[axis] = std::abs(speed * cycle) <= rounding && there ? 0 : speed;
}

bool JointLimiter::near_target(double cycle) const {
  for (Eigen::Index axis = 0; axis < joints_.size(); ++axis) {
    const double nearly = limits_[static_cast<std::size_t>(axis)].acceleration * cycle * cycle;
    if (std::abs(target_[axis] - joints_[axis]) > nearly) return false;
  }
  return true;
}

JointValues JointLimiter::stop(double cycle) const {
  JointValues where = joints_;
  for (Eigen::Index axis = 0; axis < where.size(); ++axis) {
    const double acceleration = limits_[static_cast<std::size_t>(axis)].acceleration;
    const double way = stopping_distance(std::abs(speeds_[axis]), acceleration, cycle);
    where[axis] += std::copysign(way, speeds_[axis]);
  }
  return where;
}

void JointLimiter::rest() {
  target_ = joints_;
  speeds_.setZero();
}

}  // namespace robcl::motion
