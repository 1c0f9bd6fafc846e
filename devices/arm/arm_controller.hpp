// The part of an arm's server that runs once per cycle of the control loop.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <semaphore>

#include "arm/latest.hpp"
#include "drivers/supervised_driver.hpp"
#include "gecos/base/clock.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/motion/playback.hpp"

namespace devices {

/// Runs one motion at a time, and holds the arm's position when no motion runs. Only the control
/// loop's thread may call `step`, which neither locks nor allocates unless the driver fails. Any
/// thread may call `now`. Only the thread that moves the arm may call the other methods.
///
/// The constructor enables the drives in position mode if they have it, else in velocity mode, in
/// which the loop controls the position itself. A fault of the drives ends the motion. The fault
/// stays until `reset_drives`, so that the arm does not move by itself when the cause of the fault
/// is gone.
class ArmController {
 public:
  struct Settings {
    double settled = 1e-4;      ///< rad: a joint this near to its goal has arrived
    double settle_time = 1;     ///< s that the joints may take to arrive after a plan
    double position_gain = 20;  ///< rad/s per rad of position error, in velocity mode
  };

  /// The measurements of one cycle.
  struct Reading {
    std::array<double, robcl::arm::max_axes> joints{};
    std::array<double, robcl::arm::max_axes> commanded{};  // set points in that cycle, rad
    std::array<double, 7> base_from_flange{};              // x, y, z, then quaternion w, x, y, z
    double fraction = 0;
    double remaining = 0;
    std::uint64_t cycle = 0;          // number of measurements so far
    std::int64_t measured_at_ns = 0;  // time of the Unix clock
    bool moving = false;
    DrivePower power = DrivePower::Off;
  };

  /// How a motion ended.
  enum class End { Arrived, Stopped, NotSettled, Fault };
  struct Outcome {
    End end = End::Arrived;
    Eigen::Index axis = 0;  ///< after NotSettled: index of the joint furthest from its goal
    double away = 0;        ///< rad, distance of that joint from its goal
    DriverFault fault;      ///< after Fault: what failed
  };

  /// Throws std::runtime_error with the driver's message if the driver cannot read the joint
  /// positions. Throws std::invalid_argument if the driver has torque mode only, or another number
  /// of joints than the model.
  ArmController(const robcl::arm::ArmModel& model, const Settings& settings, JointDriver& driver);
  /// Turns the drives off; the brakes then hold the arm.
  ~ArmController();
  ArmController(const ArmController&) = delete;
  ArmController& operator=(const ArmController&) = delete;

  /// Runs one control cycle of `seconds`.
  void step(double seconds);

  /// Clears a fault of the drives, in the next cycle, and enables them again.
  void reset_drives() { reset_.store(true); }
  /// Number of started cycles. It does not rise while the driver blocks.
  std::uint64_t beats() const { return beats_.load(); }

  /// Hands a motion to the control loop. @pre `wait` returned the outcome of the last motion;
  /// `plan` starts at `standing_at()`.
  void start(robcl::motion::Plan plan);
  /// Decelerates the running motion. May be called at any time, even when no motion runs.
  void stop() { stop_.store(true); }
  /// Waits at most `patience` for the outcome of the motion. Once `wait` has returned it, the next
  /// motion may start.
  std::optional<Outcome> wait(gecos::Duration patience);

  /// The set points of the joints while no motion runs: the end of the last motion or, after a
  /// fault of the driver, the measured positions.
  JointValues standing_at() const;
  Reading now() const { return reading_.read(); }

 private:
  enum class Phase { Standing, Moving, Settling };

  void enable();
  void look_after_drives();
  void begin_motion();
  void move(double seconds);
  JointCommand command_for(const JointValues& before, double seconds) const;
  std::optional<DriverFault> fault_of(const tl::expected<JointState, DriverFault>& answer,
                                      double seconds) const;
  void take(tl::expected<JointState, DriverFault> answer, bool motion_failed);
  void end_motion(Outcome outcome);
  std::optional<Outcome> settle(const JointValues& measured, double seconds);
  void publish();

  const Settings settings_;
  const Eigen::Index axes_;
  SupervisedDriver driver_;
  const JointDriver::Capabilities can_;
  const ControlMode mode_;
  robcl::arm::Kinematics forward_;

  // From start() to the end of the motion, only the control loop uses playback_ and outcome_; at
  // other times, only the thread that moves the arm.
  std::optional<robcl::motion::Playback> playback_;
  Outcome outcome_;

  std::atomic<bool> started_{false};  // publishes playback_ to the loop
  std::atomic<bool> stop_{false};
  std::atomic<bool> reset_{false};       // orders no other memory
  std::atomic<std::uint64_t> beats_{0};  // orders no other memory
  std::counting_semaphore<> ended_{0};   // publishes outcome_ to the waiting thread

  /// Used by the control loop only.
  struct Loop {
    Phase phase = Phase::Standing;
    JointState state;  ///< the driver's last answer
    JointValues command{};
    bool silent = false;    ///< the driver returned no plausible answer in the last cycle
    std::string refusal{};  ///< why the drives could not be enabled; empty if they could
    double settling = 0;    ///< s since the end of the plan
    int arrived = 0;        ///< consecutive cycles in which all joints were at their goal
    Reading last{};
  };
  Loop loop_;
  Latest<Reading> reading_;
};

}  // namespace devices
