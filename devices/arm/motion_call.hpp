// The session's side of one motion: what its handler passes to the arm, and what it answers.
#pragma once

#include "arm/arm_device.hpp"
#include "gecos/servant.hpp"
#include "robcl/manipulator_types.hpp"

namespace devices {

/// Passes on interrupts to the arm, and its progress to the caller.
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

/// One exception of the interface for one reason.
gecos::Result<void> answer(const tl::expected<void, MoveFailure>& moved);

}  // namespace devices
