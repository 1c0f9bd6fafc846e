// Motions and resets of an arm, run cycle by cycle until they end.
#pragma once

#include <functional>
#include <optional>

#include "../robcl/arms.hpp"
#include "devices/arm/arm_controller.hpp"
#include "robcl/motion/planner.hpp"
#include "standing_driver.hpp"

namespace devices {

constexpr double beat = 0.004;  // s
inline const JointValues start = robcl::joints({0, -20, 110, 0, 90, 0});

inline JointValues beside_start() {
  JointValues target = start;
  target[1] += 0.3;
  return target;
}

/// A plan from where the arm stands.
inline robcl::motion::Plan plan_of(const ArmController& controller) {
  robcl::motion::Planner planner(robcl::rx90(), {});
  return planner.joints(controller.standing_at(), beside_start(), {}).value();
}

/// How a motion away from `start` ends, `cycles` later at most; `meanwhile` once a cycle.
inline std::optional<ArmController::Outcome> outcome_of(
    ArmController& controller, const std::function<void(int)>& meanwhile = [](int) {}) {
  controller.start(playing(plan_of(controller)));
  for (int i = 0; i < 1000; ++i) {
    meanwhile(i);
    controller.step(beat);
    if (auto outcome = controller.wait(std::chrono::seconds(0))) return outcome;
  }
  return std::nullopt;
}

/// How a reset of the drives ends, 4000 cycles later at most; `meanwhile` before each cycle.
inline std::optional<ArmController::Outcome> reset(
    ArmController& controller, const std::function<void(int)>& meanwhile = [](int) {}) {
  controller.reset_drives();
  for (int i = 0; i < 4000; ++i) {
    meanwhile(i);
    controller.step(beat);
    if (auto outcome = controller.wait(std::chrono::seconds(0))) return outcome;
  }
  return std::nullopt;
}

}  // namespace devices
