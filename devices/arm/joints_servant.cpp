#include "devices/arm/joints_servant.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "devices/arm/motion_call.hpp"

namespace devices {
namespace {

/// Copies the joint positions to `joints`. If `joints` is a sequence, resizes it first.
template <typename Joints>
void write_to(Joints& joints, const JointValues& known) {
  const auto count = static_cast<std::size_t>(known.size());
  if constexpr (requires { joints.position.resize(count); }) joints.position.resize(count);
  std::copy_n(known.data(), count, joints.position.begin());
}

template <typename Joints>
Joints on_wire(const JointValues& known) {
  Joints joints;
  write_to(joints, known);
  return joints;
}

/// Returns why a caller's joint positions are invalid for an arm with `axes` joints; nullopt if
/// they are valid.
template <typename Positions>
std::optional<std::string> problem_of(const Positions& given, std::size_t axes) {
  if (given.size() != axes) {
    return "target: it has " + std::to_string(given.size()) + " joint positions, but the arm has " +
           std::to_string(axes) + " joints; give one for each joint";
  }
  const auto finite = [](double position) { return std::isfinite(position); };
  if (std::all_of(given.begin(), given.end(), finite)) return std::nullopt;
  return "target: a joint position is not finite";
}

}  // namespace

template <std::derived_from<robcl::ManipulatorServant> Interface, typename Joints>
void JointsServant<Interface, Joints>::publish_sample(const ArmDevice::Sample& sample) {
  ManipulatorServant::publish_sample(sample);
  write_to(sent_, sample.joints);
  this->publish_joints(sent_, sample.measured_at_ns);
  write_to(sent_, sample.commanded);
  this->publish_commanded_joints(sent_, sample.measured_at_ns);
}

template <std::derived_from<robcl::ManipulatorServant> Interface, typename Joints>
gecos::Result<Joints> JointsServant<Interface, Joints>::joints() {
  return on_wire<Joints>(arm().sample().joints);
}

template <std::derived_from<robcl::ManipulatorServant> Interface, typename Joints>
gecos::Result<Joints> JointsServant<Interface, Joints>::commanded_joints() {
  return on_wire<Joints>(arm().sample().commanded);
}

template <std::derived_from<robcl::ManipulatorServant> Interface, typename Joints>
gecos::Result<void> JointsServant<Interface, Joints>::move_joints(
    const Joints& target, const std::optional<robcl::Trajectory>& how, Progress& run) {
  const Eigen::Index axes = arm().model().axes();
  if (auto problem = problem_of(target.position, static_cast<std::size_t>(axes))) {
    return tl::unexpected(gecos::Fault::bad_parameter(*std::move(problem)));
  }
  const JointValues goal = Eigen::Map<const Eigen::VectorXd>(target.position.data(), axes);
  const robcl::Trajectory trajectory = how.value_or(robcl::Trajectory{});
  CallWatcher watcher(run);
  return answer(arm().move_joints(goal, pace_of(trajectory), watcher, goes_over(trajectory)));
}

template class JointsServant<robcl::SixAxisServant, robcl::Joints>;
template class JointsServant<robcl::ArticulatedArmServant, robcl::JointPositions>;

SixAxisServant::SixAxisServant(ArmDevice& arm, std::string place)
    : JointsServant(arm, std::move(place)) {
  const robcl::arm::ArmModel& model = this->arm().model();
  if (model.axes() == 6) return;
  throw std::invalid_argument("an arm with the interface SixAxis has six joints, but " +
                              model.name() + " has " + std::to_string(model.axes()));
}

}  // namespace devices
