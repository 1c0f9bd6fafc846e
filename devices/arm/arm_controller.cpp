#include "devices/arm/arm_controller.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace devices {
namespace {

constexpr int cycles_at_goal = 3;
constexpr double longest_period = 0.1;  // s
// A motion fails if the set point of a joint changed by more than this angle, in rad, between
// planning and start; for example because a brake slipped and the drives had a fault. If the motion
// started, the joint would jump by this change in the first cycle.
constexpr double moved_away = 1e-6;
// A drive follows its set points with a delay. After missed cycles, a joint may be as far from the
// last set point as it moves in this time, in s, at full speed.
constexpr double longest_lag = 0.02;

std::size_t at(Eigen::Index axis) { return static_cast<std::size_t>(axis); }

JointDriver::Properties properties_of(const JointDriver& driver,
                                      const robcl::arm::ArmModel& model) {
  const JointDriver::Properties properties = driver.properties();
  if (properties.period > 0 && properties.period <= longest_period) return properties;
  throw std::invalid_argument("the driver of " + model.name() + " has a period of " +
                              std::to_string(properties.period) + " s; give one above 0, up to " +
                              std::to_string(longest_period) + " s");
}

JointState first_state(SupervisedDriver& driver) {
  auto state = driver.read();
  if (!state) throw std::runtime_error(state.error().text);
  return std::move(*state);
}

// In velocity mode, the greatest acceleration of a commanded velocity, as a multiple of the joint's
// acceleration limit. A motion alone may need the whole acceleration limit; the rest is for the
// control of the joint positions.
constexpr double most_change = 2;

JointValues speeds_of(const robcl::arm::ArmModel& model) {
  JointValues speeds(model.axes());
  for (Eigen::Index i = 0; i < speeds.size(); ++i) speeds[i] = model.limits()[at(i)].speed;
  return speeds;
}

JointValues accelerations_of(const robcl::arm::ArmModel& model) {
  JointValues limits(model.axes());
  for (Eigen::Index i = 0; i < limits.size(); ++i) limits[i] = model.limits()[at(i)].acceleration;
  return limits;
}

/// Returns `values`, but limits the magnitude of each value to the value of the same joint in
/// `limits`.
JointValues clamped(const JointValues& values, const JointValues& limits) {
  return values.cwiseMin(limits).cwiseMax(-limits);
}

/// Returns the reason why `state` does not allow a motion; nullopt if a motion is allowed.
std::optional<DriverFault> not_ready(const JointState& state, const std::string& refusal) {
  switch (state.power) {
    case DrivePower::Fault:
      return DriverFault{"the drives have a fault: " + state.fault};
    case DrivePower::Off:
      return DriverFault{refusal.empty() ? "the drives are off" : refusal};
    case DrivePower::TurningOn:
      return DriverFault{"the drives are turning on"};
    case DrivePower::On:
      break;
  }
  if (state.brakes == Brakes::Engaged) return DriverFault{"the brakes of the drives are engaged"};
  return std::nullopt;
}

}  // namespace

ArmController::ArmController(const robcl::arm::ArmModel& model, const Settings& settings,
                             JointDriver& driver)
    : settings_(settings),
      axes_(model.axes()),
      drives_(properties_of(driver, model)),
      driver_(driver, model.limits()),
      forward_(model),
      limits_{speeds_of(model), accelerations_of(model)},
      loop_{.state = first_state(driver_), .velocity = JointValues::Zero(model.axes())},
      reading_(Reading{}) {
  enable();
  publish();
}

ArmController::~ArmController() { static_cast<void>(driver_.disable()); }

JointValues ArmController::standing_at() const {
  const Reading now = reading_.read();
  JointValues command(axes_);
  for (Eigen::Index i = 0; i < command.size(); ++i) command[i] = now.commanded[at(i)];
  return command;
}

std::uint64_t ArmController::start(std::shared_ptr<robcl::motion::TrajectoryGenerator> generator) {
  generator_ = std::move(generator);
  const std::uint64_t motion = ++motion_;
  outcome_ = {};
  stop_.store(false);
  started_.store(true);
  return motion;
}

void ArmController::reset_drives() {
  generator_.reset();
  outcome_ = {};
  stop_.store(false);
  started_.store(true);
}

std::optional<ArmController::Outcome> ArmController::wait(gecos::Duration patience) {
  if (!ended_.try_acquire_for(patience)) return std::nullopt;
  return outcome_;
}

void ArmController::step(double seconds) {
  beats_.fetch_add(1);
  const auto cycles = std::max(std::lround(seconds / drives_.period), 1L);
  const auto missed = static_cast<std::uint64_t>(cycles - 1);
  loop_.last.missed += missed;
  const bool moved = loop_.phase == Phase::Moving;
  if (loop_.phase == Phase::Standing && started_.load()) begin();
  const JointValues before = loop_.command;
  if (loop_.phase == Phase::Moving) move(moved ? missed : 0);
  if (missed > most_delayed) loop_.velocity.setZero();
  const bool undefined = !loop_.command.allFinite();
  if (undefined) loop_.command = before;
  const JointCommand command = command_for(before);
  loop_.velocity = command.velocity;
  auto answer = driver_.exchange(command, seconds);
  std::optional<Outcome> end;
  if (loop_.phase == Phase::TurningOn) {
    end = turn_on(answer, seconds);
  } else if (loop_.phase != Phase::Standing) {
    if (undefined) {
      const char* const why = loop_.threw
                                  ? "the plan of the motion threw an exception; the arm stands"
                                  : "a set point of the motion is not finite; the arm stands";
      end = Outcome{End::Fault, 0, 0, {why}};
    } else if (auto fault = fault_of(answer, seconds)) {
      end = Outcome{End::Fault, 0, 0, std::move(*fault)};
    } else if (missed > most_delayed && (fault = not_held(answer->position, before))) {
      end = Outcome{End::Fault, 0, 0, std::move(*fault)};
    } else if (loop_.phase == Phase::Settling) {
      end = settle(answer->position, seconds);
    }
  }
  take(std::move(answer), end && end->end == End::Fault);
  if (end) end_motion(std::move(*end));
}

/// Takes over the driver's answer of this cycle. After a fault, sets the set points to the measured
/// joint positions: the joints must not jump to the set points that they missed.
void ArmController::take(tl::expected<JointState, DriverFault> answer, bool motion_failed) {
  if (answer) {
    const bool stays =
        std::exchange(loop_.silent, false) || motion_failed || answer->power != DrivePower::On;
    loop_.state = std::move(*answer);
    if (stays) stay_here();
    publish();
    return;
  }
  // Until the driver answers again, readers of the measurements still see its last answer. The time
  // stamp shows the age of this answer.
  loop_.silent = true;
  stay_here();
  loop_.last.commanded = loop_.last.joints;
  reading_.write(loop_.last);
}

void ArmController::stay_here() {
  loop_.command = loop_.state.position;
  loop_.velocity.setZero();
}

void ArmController::enable() {
  const auto enabled = driver_.enable();
  loop_.refusal = enabled ? std::string() : enabled.error().text;
  if (auto state = driver_.read()) {
    loop_.state = std::move(*state);
    loop_.silent = false;
  }
  stay_here();
}

void ArmController::begin() {
  if (generator_) return begin_motion();
  begin_reset();
}

void ArmController::begin_reset() {
  if (stop_.load()) return end_motion(Outcome{End::Stopped, 0, 0, {}});  // its caller is gone
  if (const auto reset = driver_.reset(); reset) {
    enable();
  } else {
    loop_.refusal = reset.error().text;
  }
  if (!loop_.refusal.empty()) return end_motion(Outcome{End::Fault, 0, 0, {loop_.refusal}});
  loop_.phase = Phase::TurningOn;
  loop_.settling = 0;
}

/// Returns the outcome of a reset of the drives; nullopt while the drives may still turn on.
std::optional<ArmController::Outcome> ArmController::turn_on(
    const tl::expected<JointState, DriverFault>& answer, double seconds) {
  if (stop_.load()) return Outcome{End::Stopped, 0, 0, {}};
  if (!answer) return Outcome{End::Fault, 0, 0, answer.error()};
  auto why = not_ready(*answer, loop_.refusal);
  if (!why) return Outcome{End::Arrived, 0, 0, {}};
  if (answer->power == DrivePower::Fault) return Outcome{End::Fault, 0, 0, *std::move(why)};
  loop_.settling += seconds;
  if (loop_.settling < settings_.turn_on_time) return std::nullopt;
  std::ostringstream text;
  text << settings_.turn_on_time << " s after the reset, the drives are not ready: " << why->text;
  return Outcome{End::Fault, 0, 0, {text.str()}};
}

void ArmController::begin_motion() {
  loop_.last.motion = motion_;
  loop_.last.fraction = generator_->fraction();
  loop_.last.remaining = generator_->remaining();
  auto why = not_ready(loop_.state, loop_.refusal);
  if (!why && loop_.silent) why = DriverFault{"the driver does not answer"};
  if (!why && (generator_->start() - loop_.command).cwiseAbs().maxCoeff() > moved_away) {
    why = DriverFault{"the joints moved after the motion was planned; request the motion again"};
  }
  if (why) return end_motion(Outcome{End::Fault, 0, 0, std::move(*why)});
  loop_.threw = false;
  loop_.phase = Phase::Moving;
}

JointCommand ArmController::command_for(const JointValues& before) const {
  JointCommand command{loop_.command, (loop_.command - before) / drives_.period};
  if (drives_.mode == ControlMode::Velocity) {
    command.velocity += settings_.position_gain * (before - loop_.state.position);
    const JointValues change = most_change * drives_.period * limits_.accelerations;
    command.velocity = loop_.velocity + clamped(command.velocity - loop_.velocity, change);
    command.velocity = clamped(command.velocity, limits_.speeds);
  }
  return command;
}

std::optional<DriverFault> ArmController::fault_of(
    const tl::expected<JointState, DriverFault>& answer, double seconds) const {
  if (!answer) return answer.error();
  if (seconds > drives_.longest_gap) {
    return DriverFault{"the control loop stalled for " + std::to_string(seconds) +
                       " s; without commands, the drives stop by themselves after " +
                       std::to_string(drives_.longest_gap) + " s"};
  }
  return not_ready(*answer, loop_.refusal);
}

/// Returns a fault that names the first joint which the drives did not hold at the set points
/// `held` while the control loop stood still; nullopt if they held all joints.
std::optional<DriverFault> ArmController::not_held(const JointValues& measured,
                                                   const JointValues& held) const {
  for (Eigen::Index axis = 0; axis < axes_; ++axis) {
    const double away = std::abs(measured[axis] - held[axis]);
    const double furthest = longest_lag * limits_.speeds[axis];
    if (away <= furthest) continue;
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << "the control loop stood still, and joint "
         << axis + 1 << " moved meanwhile: it is " << robcl::in_deg(away)
         << " deg away from its last set point, more than the " << robcl::in_deg(furthest)
         << " deg by which it may lag behind; look at the arm before it moves again";
    return DriverFault{text.str()};
  }
  return std::nullopt;
}

void ArmController::end_motion(Outcome outcome) {
  loop_.phase = Phase::Standing;
  loop_.last.moving = false;
  reading_.write(loop_.last);
  outcome_ = std::move(outcome);
  started_.store(false);
  ended_.release();
}

void ArmController::move(std::uint64_t missed) {
  generator_->set_override(override_.load());
  if (stop_.load()) generator_->stop();
  if (missed > most_delayed) generator_->rest();
  try {
    loop_.command = generator_->advance(drives_.period);
  } catch (...) {  // some exceptions of KDL do not derive from std::exception
    loop_.threw = true;
    loop_.command.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  loop_.last.fraction = generator_->fraction();
  loop_.last.remaining = generator_->remaining();
  if (!generator_->standing()) return;
  loop_.phase = Phase::Settling;
  loop_.settling = 0;
  loop_.arrived = 0;
}

std::optional<ArmController::Outcome> ArmController::settle(const JointValues& measured,
                                                            double seconds) {
  loop_.settling += seconds;
  Eigen::Index axis = 0;
  const double away = (measured - loop_.command).cwiseAbs().maxCoeff(&axis);
  loop_.arrived = away <= settings_.settled ? loop_.arrived + 1 : 0;
  if (loop_.arrived >= cycles_at_goal) {
    return Outcome{generator_->stopping() ? End::Stopped : End::Arrived, axis, away, {}};
  }
  if (loop_.settling > settings_.settle_time) return Outcome{End::NotSettled, axis, away, {}};
  return std::nullopt;
}

void ArmController::publish() {
  for (Eigen::Index i = 0; i < axes_; ++i) {
    loop_.last.joints[at(i)] = loop_.state.position[i];
    loop_.last.commanded[at(i)] = loop_.command[i];
  }
  loop_.last.measured_at_ns = loop_.state.measured_at_ns;
  const robcl::Frame flange = forward_.base_from_flange(loop_.state.position);
  const auto [w, x, y, z] = flange.quaternion();
  loop_.last.base_from_flange = {flange.x(), flange.y(), flange.z(), w, x, y, z};
  loop_.last.moving = loop_.phase == Phase::Moving || loop_.phase == Phase::Settling;
  loop_.last.power = loop_.state.power;
  ++loop_.last.cycle;
  reading_.write(loop_.last);
}

}  // namespace devices
