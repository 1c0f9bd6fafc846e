#include "world/gripper_watch.hpp"

#include <chrono>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr auto between_tries = 500ms;
constexpr auto silent = 1s;  // a gripper that sends nothing for so long is connected to again

gecos::TimePoint now() { return std::chrono::steady_clock::now(); }

}  // namespace

GripperWatch::GripperWatch(gecos::Lab& lab, SimulatedWorld& world, std::string gripper)
    : lab_(lab), world_(world), name_(std::move(gripper)), carrier_(lab) {}

bool GripperWatch::connect() {
  if (jaws_) return true;
  if (now() < next_try_) return false;
  next_try_ = now() + between_tries;
  gecos::CreateOptions options;
  options.patience = 200ms;
  auto gripper = lab_.create<robcl::Gripper>(name_, options);
  if (!gripper) return false;
  auto jaws = gripper->jaws(gecos::stream);
  if (!jaws) return false;
  gripper_ = std::move(*gripper);
  jaws_ = std::move(*jaws);
  connected_ = now();
  return true;
}

void GripperWatch::tend() {
  carrier_.tend();
  if (connect()) {
    const auto sample = jaws_->latest();
    if (sample && sample->age <= silent) {
      see(sample->value);
    } else if (sample || now() - connected_ > silent) {
      jaws_.reset();  // jaws without power stay closed: what they hold stays held
    }
  }
  carry();
}

void GripperWatch::see(const robcl::GripperState& jaws) {
  const std::string holds = jaws.holding ? jaws.held : std::string();
  {
    const std::lock_guard lock(guard_);
    if (holds == held_) return;
  }
  if (!holds.empty()) {
    const auto parent = gripper_->parent();
    if (parent.wait_for(200ms) != gecos::State::Finished) return;
    const auto name = parent.get();
    if (!name) return;
    carrier_.follow(*name);
    carrier_.tend();
    if (!carrier_.frame()) return;  // not heard yet: seen again in the next cycle
  }
  const std::lock_guard lock(guard_);
  held_ = holds;
}

void GripperWatch::carry() {
  const std::lock_guard lock(guard_);
  if (held_.empty()) return world_.track(name_, held_, robcl::Frame());
  if (const auto carrier = carrier_.frame()) world_.track(name_, held_, *carrier);
}

}  // namespace devices
