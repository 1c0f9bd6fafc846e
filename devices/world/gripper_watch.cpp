#include "devices/world/gripper_watch.hpp"

#include <chrono>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

gecos::ReconnectOptions patient() {
  gecos::ReconnectOptions options;
  options.create.patience = 200ms;
  return options;
}

tl::expected<gecos::Stream<robcl::GripperState>, gecos::Failure> jaws_of(
    const robcl::Gripper& gripper) {
  return gripper.jaws(gecos::stream);
}

}  // namespace

GripperWatch::GripperWatch(gecos::Lab& lab, SimulatedWorld& world, std::string gripper)
    : world_(world),
      name_(std::move(gripper)),
      carrier_(lab),
      jaws_(lab, name_, jaws_of, patient()) {}

void GripperWatch::tick() {
  carrier_.tick();
  jaws_.tick();
  // Without a sample of the jaws, the gripper is assumed to hold the same body as before.
  if (const auto jaws = jaws_.latest()) see(jaws->value);
  carry();
}

void GripperWatch::see(const robcl::GripperState& jaws) {
  const std::string holds = jaws.holding ? jaws.held : std::string();
  {
    const gecos::MutexLock lock(guard_);
    if (holds == held_) return;
  }
  if (!holds.empty()) {
    const auto gripper = jaws_.proxy();
    if (!gripper) return;
    const auto parent = gripper->parent();
    if (parent.wait_for(200ms) != gecos::State::Finished) return;
    const auto name = parent.get();
    if (!name) return;
    carrier_.follow(*name);
    carrier_.tick();
    if (!carrier_.frame()) return;  // no sample yet: try again in the next cycle
  }
  const gecos::MutexLock lock(guard_);
  held_ = holds;
}

void GripperWatch::carry() {
  const gecos::MutexLock lock(guard_);
  if (held_.empty()) return world_.track(name_, held_, robcl::Frame());
  if (const auto carrier = carrier_.frame()) world_.track(name_, held_, *carrier);
}

}  // namespace devices
