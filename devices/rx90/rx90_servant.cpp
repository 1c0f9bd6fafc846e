#include "rx90/rx90_servant.hpp"

#include <variant>

namespace devices {
namespace {

using Progress = gecos::Execution<robcl::MotionProgress>;

/// The session's view of a motion, given to the arm.
class Watcher final : public MotionWatcher {
 public:
  explicit Watcher(Progress& run) : run_(run) {}
  bool interrupted() override { return run_.interrupted(); }
  void progress(double fraction, double remaining) override {
    run_.progress(fraction, {.fraction = fraction, .remaining = remaining});
  }

 private:
  Progress& run_;
};

/// One exception of the interface for one reason.
struct AsFault {
  gecos::Fault operator()(const robcl::arm::OutOfReach& failure) const {
    return robcl::OutOfReach{failure.reason.substr(0, 160)};
  }
  gecos::Fault operator()(const robcl::arm::JointLimit& failure) const {
    return robcl::JointLimit{static_cast<std::uint32_t>(failure.axis), failure.value, failure.lower,
                             failure.upper};
  }
  gecos::Fault operator()(const robcl::arm::Singular& failure) const {
    return robcl::Singular{failure.reason.substr(0, 160)};
  }
  gecos::Fault operator()(const Interrupted&) const { return gecos::Fault::interrupted(); }
  gecos::Fault operator()(const Refused& failure) const {
    return gecos::Fault::rejected(failure.reason);
  }
  gecos::Fault operator()(const DriverFault& failure) const {
    return gecos::Fault::failed(failure.text);
  }
};

gecos::Result<void> answer(const tl::expected<void, MoveFailure>& moved) {
  if (!moved) return tl::unexpected(std::visit(AsFault{}, moved.error()));
  return {};
}

robcl::motion::Pace pace_of(const robcl::Trajectory& how) {
  return {how.speed, how.acceleration, how.tool_speed, how.turn_speed};
}

robcl::Joints on_wire(const JointValues& known) {
  robcl::Joints joints;
  for (std::size_t i = 0; i < joints.position.size(); ++i) {
    joints.position[i] = known[static_cast<Eigen::Index>(i)];
  }
  return joints;
}

template <typename Wire, typename Known>
Wire on_wire(const std::optional<Known>& known) {
  return known ? static_cast<Wire>(*known) : Wire{};
}

static_assert(static_cast<int>(robcl::arm::Shoulder::Lefty) ==
              static_cast<int>(robcl::Shoulder::LEFTY));
static_assert(static_cast<int>(robcl::arm::Elbow::Below) == static_cast<int>(robcl::Elbow::BELOW));
static_assert(static_cast<int>(robcl::arm::Wrist::Flip) == static_cast<int>(robcl::Wrist::FLIP));

}  // namespace

void Rx90Servant::publish() {
  const KdlSixAxis::Sample now = arm_.sample();
  if (now.cycle == published_) return;
  published_ = now.cycle;
  publish_flange(now.flange, now.measured_at_ns);
  publish_tool(now.tool, now.measured_at_ns);
  publish_joints(on_wire(now.joints), now.measured_at_ns);
}

gecos::Result<void> Rx90Servant::mount(const std::string& carrier, const Frame& offset) {
  if (!carrier.empty()) {
    return tl::unexpected(
        robcl::MountRefused{"an RX90 weighs 111 kg and stands on the floor, not on '" + carrier +
                            "': leave the carrier empty"});
  }
  if (const auto mounted = arm_.mount(offset); !mounted) {
    return tl::unexpected(robcl::MountRefused{mounted.error().reason});
  }
  return {};
}

gecos::Result<void> Rx90Servant::set_tool_offset(const Frame& value) {
  if (const auto set = arm_.set_tool_offset(value); !set) {
    return tl::unexpected(gecos::Fault::rejected(set.error().reason));
  }
  return {};
}

gecos::Result<void> Rx90Servant::move(const Frame& goal,
                                      const std::optional<robcl::Trajectory>& how, Progress& run) {
  const robcl::Trajectory trajectory = how.value_or(robcl::Trajectory{});
  const PathKind path =
      trajectory.path == robcl::PathType::STRAIGHT ? PathKind::Straight : PathKind::Joint;
  Watcher watcher(run);
  return answer(arm_.move(goal, path, pace_of(trajectory), watcher));
}

gecos::Result<robcl::Joints> Rx90Servant::joints() { return on_wire(arm_.joints()); }

gecos::Result<void> Rx90Servant::move_joints(const robcl::Joints& target,
                                             const std::optional<robcl::Trajectory>& how,
                                             Progress& run) {
  JointValues joints(6);
  for (std::size_t i = 0; i < target.position.size(); ++i) {
    joints[static_cast<Eigen::Index>(i)] = target.position[i];
  }
  if (!joints.allFinite()) {
    return tl::unexpected(gecos::Fault::bad_parameter("target: a joint position is not finite"));
  }
  Watcher watcher(run);
  return answer(arm_.move_joints(joints, pace_of(how.value_or(robcl::Trajectory{})), watcher));
}

gecos::Result<robcl::Configuration> Rx90Servant::posture() {
  const robcl::arm::Configuration now = arm_.configuration();
  return robcl::Configuration{on_wire<robcl::Shoulder>(now.shoulder),
                              on_wire<robcl::Elbow>(now.elbow), on_wire<robcl::Wrist>(now.wrist)};
}

}  // namespace devices
