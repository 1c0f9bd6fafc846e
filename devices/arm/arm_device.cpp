#include "arm/arm_device.hpp"

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "robcl/motion/playback.hpp"

namespace devices {
namespace {

using robcl::arm::Failure;
using robcl::motion::Pace;
using robcl::motion::Plan;
using namespace std::chrono_literals;

constexpr auto beat = 5ms;  // period at which a running motion is polled
// After this number of polls without a new control cycle, the control loop counts as stalled.
constexpr int most_looks = 400;

MoveFailure as_move_failure(const Failure& failure) {
  return std::visit([](const auto& reason) { return MoveFailure(reason); }, failure);
}

std::string not_settled(const ArmController::Outcome& outcome) {
  std::ostringstream text;
  text << "joint " << outcome.axis + 1 << " does not reach its goal: it stands "
       << std::setprecision(3) << robcl::in_deg(outcome.away)
       << " deg away from the goal; check for an obstacle or a dragging brake";
  return text.str();
}

struct Words {
  std::string operator()(const Interrupted&) const {
    return "the motion was interrupted; the arm has stopped";
  }
  std::string operator()(const CorrectionsStopped&) const {
    return "no correction came for too long; the arm has stopped";
  }
  std::string operator()(const Refused& refused) const { return refused.reason; }
  std::string operator()(const DriverFault& fault) const { return fault.text; }
  template <typename Reason>
  std::string operator()(const Reason& reason) const {
    return robcl::arm::to_string(Failure(reason));
  }
};

robcl::motion::ToolLimits lower_of(const robcl::motion::ToolLimits& one,
                                   const robcl::motion::ToolLimits& other) {
  return {.speed = std::min(one.speed, other.speed),
          .acceleration = std::min(one.acceleration, other.acceleration),
          .turn_speed = std::min(one.turn_speed, other.turn_speed),
          .turn_acceleration = std::min(one.turn_acceleration, other.turn_acceleration)};
}

template <typename Choice>
bool has(const std::optional<Choice>& present, const std::optional<Choice>& wanted) {
  return !wanted || present == wanted;
}

/// Returns why the arm does not have the configuration `wanted` on a straight line, on which it
/// keeps the configuration `present`.
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

std::uint64_t unix_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

JointValues values_of(const std::array<double, robcl::arm::max_axes>& joints, Eigen::Index axes) {
  return Eigen::Map<const Eigen::VectorXd>(joints.data(), axes);
}

}  // namespace

std::string to_string(const MoveFailure& failure) { return std::visit(Words{}, failure); }

ArmDevice::ArmDevice(const robcl::arm::ArmModel& model, const Settings& settings,
                     JointDriver& driver)
    : model_(model),
      tool_limits_(settings.tool_limits),
      controller_(model, settings.control, driver),
      planner_(model, settings.tool_limits),
      pose_epoch_(unix_ms()),
      flange_from_tool_(settings.tool_offset),
      postures_(robcl::arm::make_inverse(model)) {}

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

robcl::arm::Configuration ArmDevice::configuration() const {
  const JointValues now = sample().joints;
  const gecos::MutexLock lock(reading_);
  return postures_->configuration(now);
}

tl::expected<void, Refused> ArmDevice::mount(const Frame& world_from_base) {
  if (!moving_.try_lock())
    return tl::unexpected(Refused{"the arm is moving; mount it when it has stopped"});
  const gecos::MutexLock standing(moving_, std::adopt_lock);
  const gecos::MutexLock lock(reading_);
  world_from_base_ = world_from_base;
  ++pose_epoch_;
  return {};
}

tl::expected<void, Refused> ArmDevice::set_tool_offset(const Frame& flange_from_tool) {
  if (!moving_.try_lock())
    return tl::unexpected(Refused{"the arm is moving; change its tool when it has stopped"});
  const gecos::MutexLock standing(moving_, std::adopt_lock);
  const gecos::MutexLock lock(reading_);
  flange_from_tool_ = flange_from_tool;
  return {};
}

/// `make`: makes the motion that starts at the joint positions of its argument.
template <typename Make>
tl::expected<void, MoveFailure> ArmDevice::run(MotionWatcher& watcher, Make make) {
  if (!moving_.try_lock())
    return tl::unexpected(Refused{"the arm is moving for another caller; wait until it stops"});
  const gecos::MutexLock standing(moving_, std::adopt_lock);
  if (unfinished_ && !controller_.wait(0ms)) {
    return tl::unexpected(
        DriverFault{"the control loop has stalled: a call of the driver does not return"});
  }
  unfinished_ = false;
  tl::expected<Generator, MoveFailure> generator = make(controller_.standing_at());
  if (!generator) return tl::unexpected(std::move(generator.error()));
  return perform(*std::move(generator), watcher);
}

template <typename MakePlan>
tl::expected<void, MoveFailure> ArmDevice::run_plan(const Pace& pace, MotionWatcher& watcher,
                                                    MakePlan make_plan) {
  if (auto problem = robcl::motion::problem_of(pace)) return tl::unexpected(Refused{*problem});
  return run(watcher, [&](const JointValues& from) -> tl::expected<Generator, MoveFailure> {
    tl::expected<Plan, Failure> plan = make_plan(from);
    if (!plan) return tl::unexpected(as_move_failure(plan.error()));
    return std::make_shared<robcl::motion::Playback>(*std::move(plan));
  });
}

tl::expected<void, MoveFailure> ArmDevice::move(
    const Frame& world_from_goal, PathKind path, const Pace& pace, MotionWatcher& watcher,
    const std::optional<robcl::arm::Configuration>& wanted) {
  if (path == PathKind::Straight && wanted) {
    if (auto why = why_not_straight(*wanted, configuration())) return tl::unexpected(*why);
  }
  return run_plan(pace, watcher, [&](const JointValues& from) {
    moving_.assert_held();
    const Frame base_from_goal = base().inverse() * world_from_goal;
    const Frame tool = tool_offset();
    return path == PathKind::Straight
               ? planner_.straight(from, base_from_goal, tool, pace)
               : planner_.joints_to(from, base_from_goal, tool, pace, wanted);
  });
}

tl::expected<void, MoveFailure> ArmDevice::move_to(const JointValues& target, const Pace& pace,
                                                   MotionWatcher& watcher) {
  return run_plan(pace, watcher, [&](const JointValues& from) {
    moving_.assert_held();
    return planner_.joints(from, target, pace, tool_offset());
  });
}

tl::expected<void, MoveFailure> ArmDevice::follow(
    robcl::motion::CorrectionAxes axes, robcl::motion::FollowLimits limits,
    std::shared_ptr<robcl::motion::CorrectionSource> source, MotionWatcher& watcher) {
  limits.tool = lower_of(limits.tool, tool_limits_);
  std::shared_ptr<robcl::motion::Following> following;
  auto ended = run(watcher, [&](const JointValues& from) -> tl::expected<Generator, MoveFailure> {
    following = std::make_shared<robcl::motion::Following>(model_, from, tool_offset(), axes,
                                                           limits, std::move(source));
    return following;
  });
  const bool stopped = !ended && std::holds_alternative<Interrupted>(ended.error());
  if (stopped && following->expired()) return tl::unexpected(CorrectionsStopped{});
  return ended;
}

tl::expected<void, MoveFailure> ArmDevice::perform(Generator generator, MotionWatcher& watcher) {
  if (watcher.interrupted()) return tl::unexpected(Interrupted{});
  const double duration = generator->remaining();
  const std::uint64_t motion = controller_.start(std::move(generator));
  const auto outcome = await_end(motion, duration, watcher);
  if (!outcome) {
    controller_.stop();  // ends the motion if the control loop continues later
    unfinished_ = true;
    return tl::unexpected(
        DriverFault{"the control loop has stalled: a call of the driver does not return"});
  }
  switch (outcome->end) {
    case ArmController::End::Arrived:
      return {};
    case ArmController::End::Stopped:
      return tl::unexpected(Interrupted{});
    case ArmController::End::NotSettled:
      return tl::unexpected(DriverFault{not_settled(*outcome)});
    case ArmController::End::Fault:
      break;
  }
  return tl::unexpected(outcome->fault);
}

/// Waits for the end of the motion and returns its outcome. Returns nullopt if the control loop
/// began no cycle during `most_looks` polls. Counts polls and not time, because time also passes
/// while the process is suspended.
std::optional<ArmController::Outcome> ArmDevice::await_end(std::uint64_t motion, double duration,
                                                           MotionWatcher& watcher) {
  std::uint64_t seen = controller_.beats();
  for (int looks = 0; looks < most_looks; ++looks) {
    auto outcome = controller_.wait(beat);
    if (watcher.interrupted()) controller_.stop();
    const ArmController::Reading now = controller_.now();
    // Before the first cycle of this motion, `now` is about the motion before it.
    const bool begun = now.motion == motion;
    watcher.progress(begun ? now.fraction : 0, begun ? now.remaining : duration);
    if (outcome) return outcome;
    if (controller_.beats() != seen) looks = 0;
    seen = controller_.beats();
  }
  return std::nullopt;
}

SixAxisDevice::SixAxisDevice(const robcl::arm::ArmModel& model, const Settings& settings,
                             JointDriver& driver)
    : ArmDevice(model, settings, driver) {
  if (model.axes() != 6) {
    throw std::invalid_argument(model.name() + " has " + std::to_string(model.axes()) +
                                " axes, but a six-axis arm needs six");
  }
}

}  // namespace devices
