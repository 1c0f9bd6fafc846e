#include "devices/arm/manipulator_servant.hpp"

#include <utility>

#include "devices/arm/motion_call.hpp"

namespace devices {
namespace {

/// Tells the arm when a call was interrupted. Does not tell the caller the progress of the arm.
class InterruptionWatcher final : public MotionWatcher {
 public:
  explicit InterruptionWatcher(gecos::Execution<>& run) : run_(run) {}
  bool interrupted() override { return run_.interrupted(); }
  void progress(double, double) override {}

 private:
  gecos::Execution<>& run_;
};

template <class Run>
NextConfiguration::Issuer issuer_of(const Run& run) {
  return {run.caller().session, run.status_epoch()};
}

}  // namespace

gecos::Result<void> ManipulatorServant::restart_drives(gecos::Execution<>& run) {
  InterruptionWatcher watcher(run);
  return answer(arm_.reset_drives(watcher));
}

void ManipulatorServant::publish() {
  if (following_.try_lock()) {
    const gecos::MutexLock nobody_follows(following_, std::adopt_lock);
    while (alter().next()) {  // next() judges each sample, and counts its refusal
    }
  }
  const ArmDevice::Sample now = arm_.sample();
  if (now.cycle == published_) return;
  published_ = now.cycle;
  publish_sample(now);
  if (std::exchange(moved_, now.moving) && !now.moving) publish_stood({.tool = now.tool});
}

void ManipulatorServant::publish_sample(const ArmDevice::Sample& sample) {
  publish_flange(sample.flange, sample.measured_at_ns);
  publish_tool(sample.tool, sample.measured_at_ns);
}

gecos::Result<void> ManipulatorServant::mount(const std::string& carrier, const Frame& offset) {
  if (!carrier.empty()) {
    return tl::unexpected(
        robcl::MountRefused{place_ + ", not on '" + carrier + "': leave the carrier empty"});
  }
  if (const auto mounted = arm_.mount(offset); !mounted) {
    return tl::unexpected(robcl::MountRefused{mounted.error().reason});
  }
  return {};
}

gecos::Result<robcl::Configuration> ManipulatorServant::posture() {
  return on_wire(arm_.configuration());
}

gecos::Result<void> ManipulatorServant::set_tool_offset(const Frame& value) {
  if (const auto set = arm_.set_tool_offset(value); !set) {
    return tl::unexpected(gecos::Fault::rejected(set.error().reason));
  }
  return {};
}

gecos::Result<void> ManipulatorServant::move(const Frame& goal,
                                             const std::optional<robcl::Trajectory>& how,
                                             const std::optional<std::uint64_t>& pose_epoch,
                                             Progress& run) {
  if (pose_epoch && *pose_epoch != arm_.pose_epoch()) {
    return tl::unexpected(gecos::Fault::rejected(
        "the base of the arm has been mounted elsewhere since the goal was computed: its pose "
        "epoch was " +
        std::to_string(*pose_epoch) + " and is " + std::to_string(arm_.pose_epoch()) +
        "; read the base and compute the goal again"));
  }
  const robcl::Trajectory trajectory = how.value_or(robcl::Trajectory{});
  const PathKind path =
      trajectory.path == robcl::PathType::STRAIGHT ? PathKind::Straight : PathKind::Joint;
  auto wanted = configuration_of(trajectory);
  std::optional<robcl::arm::Configuration> set_before;
  if (path == PathKind::Joint) {
    set_before = next_configuration_.take(issuer_of(run));
    if (!wanted) wanted = set_before;
  }
  CallWatcher watcher(run);
  const auto moved =
      arm_.move(goal, path, pace_of(trajectory), watcher, wanted, goes_over(trajectory));
  if (set_before && !moved && is_refusal(moved.error())) {
    next_configuration_.give_back(issuer_of(run), *set_before);
  }
  return answer(moved);
}

gecos::Result<void> ManipulatorServant::set_configuration(const robcl::Configuration& wanted,
                                                          gecos::Execution<>& run) {
  const robcl::arm::Configuration known = from_wire(wanted);
  if (!arm_.has_configurations() && known != robcl::arm::Configuration{}) {
    return tl::unexpected(gecos::Fault::rejected(
        "this arm has no configurations to choose from; leave all members of `wanted` out"));
  }
  next_configuration_.set(issuer_of(run), known);
  return {};
}

gecos::Result<void> ManipulatorServant::follow(robcl::FollowMode axes,
                                               const std::optional<robcl::FollowLimits>& limits,
                                               FollowCall::Progress& run) {
  const gecos::MutexLock reads(following_);
  FollowCall call(run, alter());
  const auto known = axes == robcl::FollowMode::IN_BASE ? robcl::motion::CorrectionAxes::Base
                                                        : robcl::motion::CorrectionAxes::Tool;
  return call.answer(arm_.follow(known, limits_of(limits.value_or(robcl::FollowLimits{})),
                                 call.corrections(), call));
}

}  // namespace devices
