#include "arm/arm_controller.hpp"

#include <chrono>
#include <utility>

namespace devices {
namespace {

constexpr int cycles_at_goal = 3;

std::size_t at(Eigen::Index axis) { return static_cast<std::size_t>(axis); }

std::int64_t unix_ns() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

}  // namespace

ArmController::ArmController(const robcl::arm::ArmModel& model, const Settings& settings,
                             JointDriver& driver)
    : settings_(settings),
      axes_(model.axes()),
      driver_(driver),
      forward_(model),
      command_(driver.measured()),
      reading_(Reading{}) {
  publish(command_);
}

JointValues ArmController::standing_at() const {
  const Reading now = reading_.read();
  JointValues command(axes_);
  for (Eigen::Index i = 0; i < command.size(); ++i) command[i] = now.commanded[at(i)];
  return command;
}

void ArmController::start(robcl::motion::Plan plan) {
  playback_.emplace(std::move(plan));
  outcome_ = {};
  stop_.store(false);
  started_.store(true);
}

std::optional<ArmController::Outcome> ArmController::wait(gecos::Duration patience) {
  if (!ended_.try_acquire_for(patience)) return std::nullopt;
  return outcome_;
}

void ArmController::step(double seconds) {
  if (phase_ == Phase::Standing && started_.load()) phase_ = Phase::Moving;
  if (phase_ == Phase::Moving) move(seconds);
  auto measured = driver_.exchange(command_, seconds);
  std::optional<Outcome> end;
  if (measured) {
    if (phase_ == Phase::Settling) end = settle(*measured, seconds);
  } else if (phase_ != Phase::Standing) {
    end = Outcome{End::Fault, 0, 0, std::move(measured.error())};
  }
  if (end) phase_ = Phase::Standing;
  // Without an answer from the driver the last one stays what is known, and its stamp says how old
  // it is. Where it stands when the driver is back, it shall stay.
  if (measured) {
    if (std::exchange(silent_, false)) command_ = *measured;
    publish(*measured);
  } else {
    silent_ = true;
    for (Eigen::Index i = 0; i < command_.size(); ++i) command_[i] = last_.joints[at(i)];
    last_.commanded = last_.joints;
  }
  if (!end) return;
  last_.moving = false;
  reading_.write(last_);
  outcome_ = std::move(*end);
  started_.store(false);
  ended_.release();
}

void ArmController::move(double seconds) {
  if (stop_.load()) playback_->stop();
  command_ = playback_->advance(seconds);
  last_.fraction = playback_->fraction();
  last_.remaining = playback_->remaining();
  if (!playback_->standing()) return;
  phase_ = Phase::Settling;
  settling_ = 0;
  arrived_ = 0;
}

std::optional<ArmController::Outcome> ArmController::settle(const JointValues& measured,
                                                            double seconds) {
  settling_ += seconds;
  Eigen::Index axis = 0;
  const double away = (measured - command_).cwiseAbs().maxCoeff(&axis);
  arrived_ = away <= settings_.settled ? arrived_ + 1 : 0;
  if (arrived_ >= cycles_at_goal) {
    return Outcome{playback_->stopping() ? End::Stopped : End::Arrived, axis, away, {}};
  }
  if (settling_ > settings_.settle_time) return Outcome{End::NotSettled, axis, away, {}};
  return std::nullopt;
}

void ArmController::publish(const JointValues& measured) {
  for (Eigen::Index i = 0; i < measured.size(); ++i) {
    last_.joints[at(i)] = measured[i];
    last_.commanded[at(i)] = command_[i];
  }
  last_.measured_at_ns = unix_ns();
  const robcl::Frame flange = forward_.base_from_flange(measured);
  const auto [w, x, y, z] = flange.quaternion();
  last_.base_from_flange = {flange.x(), flange.y(), flange.z(), w, x, y, z};
  last_.moving = phase_ != Phase::Standing;
  ++last_.cycle;
  reading_.write(last_);
}

}  // namespace devices
