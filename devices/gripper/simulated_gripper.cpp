#include "devices/gripper/simulated_gripper.hpp"

#include <algorithm>
#include <cmath>

namespace devices {

SimulatedGripper::SimulatedGripper(const Settings& settings)
    : settings_(settings), target_(settings.max_width / 2) {
  state_.width = target_;
}

SimulatedGripper::State SimulatedGripper::state() const {
  const gecos::MutexLock lock(guard_);
  return state_;
}

tl::expected<void, SimulatedGripper::OutOfRange> SimulatedGripper::open(
    double width, const std::optional<Contact>& contact) {
  if (!(width >= 0 && width <= settings_.max_width)) {  // this comparison also refuses NaN
    return tl::unexpected(OutOfRange{width, 0, settings_.max_width});
  }
  const gecos::MutexLock lock(guard_);
  const bool narrows = width < state_.width;
  target_ = narrows && contact ? std::max(width, contact->width) : width;
  force_at_target_ = 0;
  body_at_target_.clear();
  state_ = {state_.width, 0, target_ != state_.width, false, {}};
  return {};
}

tl::expected<void, SimulatedGripper::OutOfRange> SimulatedGripper::close(
    double force, const std::optional<Contact>& contact) {
  if (!(force > 0 && force <= settings_.max_force)) {
    return tl::unexpected(OutOfRange{force, 0, settings_.max_force});
  }
  const gecos::MutexLock lock(guard_);
  if (state_.holding) {  // only the force changes: the jaws do not let go
    state_.force = force;
    return {};
  }
  target_ = contact ? std::min(contact->width, state_.width) : 0;
  force_at_target_ = contact ? force : 0;
  body_at_target_ = contact ? contact->body : std::string();
  state_.moving = true;
  return {};
}

void SimulatedGripper::halt() {
  const gecos::MutexLock lock(guard_);
  target_ = state_.width;
  state_.moving = false;
}

void SimulatedGripper::step(double seconds) {
  const gecos::MutexLock lock(guard_);
  if (!state_.moving) return;
  const double most = settings_.speed * seconds;
  const double change = std::clamp(target_ - state_.width, -most, most);
  state_.width += change;
  if (std::abs(target_ - state_.width) > 1e-9) return;
  state_.width = target_;
  state_.moving = false;
  if (force_at_target_ <= 0) return;
  state_.holding = true;
  state_.force = force_at_target_;
  state_.held = body_at_target_;
}

}  // namespace devices
