#include "devices/arm/arm_device.hpp"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <utility>

namespace devices {
namespace {

using robcl::motion::Move;
using robcl::motion::Pace;
using robcl::motion::Planner;

robcl::motion::ToolLimits lower_of(const robcl::motion::ToolLimits& one,
                                   const robcl::motion::ToolLimits& other) {
  return {.speed = std::min(one.speed, other.speed),
          .acceleration = std::min(one.acceleration, other.acceleration),
          .turn_speed = std::min(one.turn_speed, other.turn_speed),
          .turn_acceleration = std::min(one.turn_acceleration, other.turn_acceleration)};
}

// The greatest distances of the base from the origin of the world, and of the tool from the flange.
// At greater distances, rounding errors of the coordinates are too large for the motions of an arm.
constexpr double furthest_base = 1e7, furthest_tool = 1000;  // m

/// Returns why `frame` is refused, if its origin is further than `furthest` metres from the origin
/// of its reference frame; else nullopt. `what` is the name of the frame in the text.
std::optional<Refused> too_far(const char* what, const Frame& frame, double furthest) {
  const double away = frame.position().stableNorm();
  if (away <= furthest) return std::nullopt;
  std::ostringstream text;
  text << what << " is " << away << " m away, but it can be at most " << furthest
       << " m away: is its position in millimetres?";
  return Refused{text.str()};
}

template <typename Choice>
bool has(const std::optional<Choice>& present, const std::optional<Choice>& wanted) {
  return !wanted || present == wanted;
}

/// Returns why a straight move cannot end in the configuration `wanted`: the move keeps the
/// configuration `present`. Returns nullopt if `present` is one that `wanted` admits.
std::optional<Refused> why_not_straight(const robcl::arm::Configuration& wanted,
                                        const robcl::arm::Configuration& present) {
  if (has(present.shoulder, wanted.shoulder) && has(present.elbow, wanted.elbow) &&
      has(present.wrist, wanted.wrist)) {
    return std::nullopt;
  }
  std::ostringstream text;
  text << "a straight move keeps the configuration " << present << " and cannot end as " << wanted
       << "; use a joint move";
  return Refused{text.str()};
}

tl::expected<Move, MoveFailure> made(tl::expected<Move, robcl::arm::Failure> move) {
  if (!move) return tl::unexpected(as_move_failure(move.error()));
  return *std::move(move);
}

std::uint64_t unix_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

JointValues values_of(const std::array<double, robcl::arm::max_axes>& joints, Eigen::Index axes) {
  return Eigen::Map<const Eigen::VectorXd>(joints.data(), axes);
}

}  // namespace

ArmDevice::ArmDevice(const robcl::arm::ArmModel& model, const Settings& settings,
                     JointDriver& driver)
    : model_(model),
      tool_limits_(settings.tool_limits),
      clock_(settings.clock_speed),
      controller_(model, settings.control, driver),
      smoothing_(robcl::motion::Smoothing::over(settings.seconds_to_full_acceleration,
                                                controller_.cycle())),
      motion_(controller_, Planner(model, settings.tool_limits, smoothing_), clock_.speed()),
      pose_epoch_(unix_ms()),
      flange_from_tool_(settings.tool_offset),
      postures_(robcl::arm::make_inverse(model)),
      has_configurations_(postures_->has_configurations()) {}

Frame ArmDevice::base() const {
  const gecos::MutexLock lock(reading_);
  return world_from_base_;
}

std::uint64_t ArmDevice::pose_epoch() const {
  const gecos::MutexLock lock(reading_);
  return pose_epoch_;
}

Frame ArmDevice::tool_offset() const {
  const gecos::MutexLock lock(reading_);
  return flange_from_tool_;
}

ArmDevice::Sample ArmDevice::sample() const {
  const ArmController::Reading now = controller_.now();
  Sample sample;
  const auto [x, y, z, qw, qx, qy, qz] = now.base_from_flange;
  {
    const gecos::MutexLock lock(reading_);
    sample.flange = world_from_base_ * Frame::from_quaternion(x, y, z, qw, qx, qy, qz);
    sample.tool = sample.flange * flange_from_tool_;
  }
  sample.joints = values_of(now.joints, model_.axes());
  sample.commanded = values_of(now.commanded, model_.axes());
  sample.cycle = now.cycle;
  sample.moving = now.moving;
  sample.measured_at_ns = now.measured_at_ns;
  return sample;
}

double ArmDevice::braking_time() const {
  double longest = std::max(tool_limits_.speed / tool_limits_.acceleration,
                            tool_limits_.turn_speed / tool_limits_.turn_acceleration);
  for (const robcl::arm::JointLimits& joint : model_.limits()) {
    longest = std::max(longest, joint.speed / joint.acceleration);
  }
  // The limit of jerk averages the acceleration over a time, the window. So a stop takes two
  // windows longer: one until an acceleration at the start of the stop has fallen to 0, and one
  // until the set points have come to rest.
  return longest + 2 * smoothing_.window;
}

robcl::arm::Configuration ArmDevice::configuration() const {
  const JointValues now = sample().joints;
  const gecos::MutexLock lock(reading_);
  return postures_->configuration(now);
}

tl::expected<void, Refused> ArmDevice::mount(const Frame& world_from_base) {
  if (auto far = too_far("the base", world_from_base, furthest_base)) {
    return tl::unexpected(*std::move(far));
  }
  const bool mounted = motion_.while_standing([&] {
    const gecos::MutexLock lock(reading_);
    world_from_base_ = world_from_base;
    ++pose_epoch_;
  });
  if (!mounted) return tl::unexpected(Refused{"the arm is moving; mount it when it has stopped"});
  return {};
}

tl::expected<void, Refused> ArmDevice::set_tool_offset(const Frame& flange_from_tool) {
  if (auto far = too_far("the tool", flange_from_tool, furthest_tool)) {
    return tl::unexpected(*std::move(far));
  }
  const bool set = motion_.while_standing([&] {
    const gecos::MutexLock lock(reading_);
    flange_from_tool_ = flange_from_tool;
  });
  if (!set) {
    return tl::unexpected(Refused{"the arm is moving; change its tool when it has stopped"});
  }
  return {};
}

tl::expected<void, MoveFailure> ArmDevice::move(
    const Frame& world_from_goal, PathKind path, const Pace& pace, MotionWatcher& watcher,
    const std::optional<robcl::arm::Configuration>& wanted, bool goes_over) {
  const auto make = [&](Planner& planner,
                        const JointValues& from) -> tl::expected<Move, MoveFailure> {
    const Frame base_from_goal = base().inverse() * world_from_goal;
    if (path == PathKind::Joint) {
      return made(planner.joint_move_to(from, base_from_goal, tool_offset(), pace, wanted));
    }
    if (wanted) {
      if (auto why = why_not_straight(*wanted, planner.configuration(from))) {
        return tl::unexpected(*std::move(why));
      }
    }
    return made(planner.straight_move(from, base_from_goal, tool_offset(), pace));
  };
  auto problem = path == PathKind::Joint ? robcl::motion::problem_of_joint_move(pace)
                                         : robcl::motion::problem_of(pace);
  if (problem) return tl::unexpected(Refused{*std::move(problem)});
  return motion_.move({make, goes_over}, watcher);
}

tl::expected<void, MoveFailure> ArmDevice::move_joints(const JointValues& target, const Pace& pace,
                                                       MotionWatcher& watcher, bool goes_over) {
  if (auto problem = robcl::motion::problem_of_joint_move(pace)) {
    return tl::unexpected(Refused{*std::move(problem)});
  }
  const auto make = [&](Planner& planner, const JointValues& from) {
    return made(planner.joint_move(from, target, pace, tool_offset()));
  };
  return motion_.move({make, goes_over}, watcher);
}

tl::expected<void, MoveFailure> ArmDevice::follow(
    robcl::motion::CorrectionAxes axes, robcl::motion::FollowLimits limits,
    std::shared_ptr<robcl::motion::CorrectionSource> source, MotionWatcher& watcher) {
  limits.tool = lower_of(limits.tool, tool_limits_);
  std::shared_ptr<robcl::motion::Following> following;
  const auto make = [&](const JointValues& from) {
    following = std::make_shared<robcl::motion::Following>(model_, from, tool_offset(), axes,
                                                           limits, std::move(source));
    return following;
  };
  auto ended = motion_.alone(make, watcher);
  const bool stopped = !ended && std::holds_alternative<Interrupted>(ended.error());
  if (stopped && following && following->expired()) return tl::unexpected(CorrectionsStopped{});
  return ended;
}

}  // namespace devices
