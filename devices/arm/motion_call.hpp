// Code for the handlers of motions: connects a running handler to the arm, and makes the reply of
// the handler.
#pragma once

#include "devices/arm/arm_device.hpp"
#include "gecos/servant.hpp"
#include "robcl/manipulator_types.hpp"

namespace devices {

/// A MotionWatcher for the handler of a call: passes an interruption of the call to the arm, and
/// the progress of the motion to the caller.
class CallWatcher final : public MotionWatcher {
 public:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  explicit CallWatcher(Progress& run) : run_(run) {}
  bool interrupted() override { return run_.interrupted(); }
  void progress(double fraction, double remaining) override {
    run_.progress(fraction, {.fraction = fraction,
                             .remaining = remaining,
                             .corner = corner_,
                             .speed_override = factor_});
  }
  std::uint64_t caller() const override { return run_.caller().session; }
  void taken() override { run_.let_next(); }
  void passes_goal(double distance) override { corner_ = distance; }
  void scaled(double factor) override {
    factor_ = factor == 1 ? std::nullopt : std::optional(factor);
  }

 private:
  Progress& run_;
  std::optional<double> corner_;  // distance at which the tool passes the goal, m
  std::optional<double> factor_;  // of the speed; nullopt: 1
};

/// Returns whether the arm may go over into the next motion and need not stand at the goal.
inline bool goes_over(const robcl::Trajectory& how) { return how.at_goal == robcl::Blend::NOBREAK; }
robcl::motion::Pace pace_of(const robcl::Trajectory& how);
/// Returns the configuration in which the move must end; nullopt if the arm must keep its present
/// configuration.
std::optional<robcl::arm::Configuration> configuration_of(const robcl::Trajectory& how);
robcl::arm::Configuration from_wire(const robcl::Configuration& asked);
robcl::Configuration on_wire(const robcl::arm::Configuration& known);

/// Returns the reply to a call that moves the arm. Converts each failure to an exception of the
/// interface or to a fault.
gecos::Result<void> answer(const tl::expected<void, MoveFailure>& moved);

}  // namespace devices
