// Connects the handler of a motion to the arm, and makes the handler's reply.
#pragma once

#include "arm/arm_device.hpp"
#include "gecos/servant.hpp"
#include "robcl/manipulator_types.hpp"

namespace devices {

/// Passes interrupts of the call to the arm, and the arm's progress to the caller.
class CallWatcher final : public MotionWatcher {
 public:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  explicit CallWatcher(Progress& run) : run_(run) {}
  bool interrupted() override { return run_.interrupted(); }
  void progress(double fraction, double remaining) override {
    run_.progress(fraction, {.fraction = fraction, .remaining = remaining});
  }

 private:
  Progress& run_;
};

robcl::motion::Pace pace_of(const robcl::Trajectory& how);

/// The reply to a call that moves the arm. Each failure maps to one exception of the interface.
gecos::Result<void> answer(const tl::expected<void, MoveFailure>& moved);

}  // namespace devices
