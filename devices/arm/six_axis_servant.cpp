#include "devices/arm/six_axis_servant.hpp"

#include <stdexcept>
#include <utility>

#include "devices/arm/motion_call.hpp"

namespace devices {
namespace {

robcl::Joints on_wire(const JointValues& known) {
  robcl::Joints joints;
  for (std::size_t i = 0; i < joints.position.size(); ++i) {
    joints.position[i] = known[static_cast<Eigen::Index>(i)];
  }
  return joints;
}

JointValues from_wire(const robcl::Joints& joints) {
  JointValues known(6);
  for (std::size_t i = 0; i < joints.position.size(); ++i) {
    known[static_cast<Eigen::Index>(i)] = joints.position[i];
  }
  return known;
}

}  // namespace

SixAxisServant::SixAxisServant(ArmDevice& arm, std::string place)
    : ManipulatorServant(arm, std::move(place)) {
  const robcl::arm::ArmModel& model = arm.model();
  if (model.axes() == 6) return;
  throw std::invalid_argument("an arm with the interface SixAxis has six joints, but " +
                              model.name() + " has " + std::to_string(model.axes()));
}

void SixAxisServant::publish_sample(const ArmDevice::Sample& sample) {
  ManipulatorServant::publish_sample(sample);
  publish_joints(on_wire(sample.joints), sample.measured_at_ns);
  publish_commanded_joints(on_wire(sample.commanded), sample.measured_at_ns);
}

gecos::Result<robcl::Joints> SixAxisServant::joints() { return on_wire(arm().sample().joints); }

gecos::Result<robcl::Joints> SixAxisServant::commanded_joints() {
  return on_wire(arm().sample().commanded);
}

gecos::Result<void> SixAxisServant::move_joints(const robcl::Joints& target,
                                                const std::optional<robcl::Trajectory>& how,
                                                Progress& run) {
  const JointValues joints = from_wire(target);
  if (!joints.allFinite()) {
    return tl::unexpected(gecos::Fault::bad_parameter("target: a joint position is not finite"));
  }
  const robcl::Trajectory trajectory = how.value_or(robcl::Trajectory{});
  CallWatcher watcher(run);
  return answer(arm().move_joints(joints, pace_of(trajectory), watcher, goes_over(trajectory)));
}

}  // namespace devices
