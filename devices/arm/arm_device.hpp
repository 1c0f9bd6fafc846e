// An arm that stands in the world and carries a tool. Only one caller at a time may move the arm.
#pragma once

#include <memory>
#include <optional>

#include "devices/arm/arm_controller.hpp"
#include "devices/arm/arm_motion.hpp"
#include "devices/support/lab_clock.hpp"
#include "gecos/base/mutex.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/motion/following.hpp"

namespace devices {

using robcl::Frame;

enum class PathKind { Joint, Straight };

/// An arm with any driver. Only the control loop calls `step`; any thread may call the other
/// methods.
class ArmDevice {
 public:
  struct Settings {
    robcl::motion::ToolLimits tool_limits{};
    double seconds_to_full_acceleration = 0;  ///< limit of jerk; 0 if there is none
    Frame tool_offset{};                      ///< tool frame seen from the flange
    ArmController::Settings control{};
    double clock_speed = 1;  ///< of `clock()`; @pre 1 unless the joints are simulated
  };

  ArmDevice(const robcl::arm::ArmModel& model, const Settings& settings, JointDriver& driver);

  /// The clock of simulated time. All times and limits of a motion are measured by this clock, and
  /// the caller of `step` must use this clock.
  LabClock& clock() { return clock_; }
  /// Runs one cycle of the control loop. `seconds` is the time since the previous cycle.
  void step(double seconds) { controller_.step(seconds); }

  /// The measurements of one cycle of the control loop.
  struct Sample {
    Frame flange;             ///< pose in the world
    Frame tool;               ///< pose in the world
    JointValues joints;       ///< measured, rad
    JointValues commanded;    ///< set points of the same cycle, rad
    std::uint64_t cycle = 0;  ///< number of measurements so far
    bool moving = false;
    std::int64_t measured_at_ns = 0;  ///< time of the Unix clock
  };
  Sample sample() const;

  Frame base() const;
  /// Returns a number that changes whenever the base of the arm is mounted elsewhere. The first
  /// number is the Unix time in ms, so that a restarted program has another number.
  std::uint64_t pose_epoch() const;
  Frame tool_offset() const;                            ///< tool seen from the flange
  double cycle() const { return controller_.cycle(); }  ///< period of the control loop, s
  /// Returns how long a stop takes, in s: the time in which the slowest joint brakes from full
  /// speed to rest, or the tool on a straight line if that takes longer. If there is a limit of
  /// jerk, the arm may still accelerate when the stop begins; the returned time includes this.
  /// Where the joints move on curves so that the tool moves straight, a stop can take longer than
  /// the returned time.
  double braking_time() const;
  bool moving() const { return controller_.now().moving; }
  /// Returns the number of control cycles that were missed so far.
  std::uint64_t missed_cycles() const { return controller_.now().missed; }
  /// Scales the speed of this and all later motions; see ArmController::set_override.
  void set_override(double factor) { controller_.set_override(factor); }
  double speed_override() const { return controller_.speed_override(); }
  DrivePower power() const { return controller_.now().power; }
  robcl::arm::Configuration configuration() const;
  bool has_configurations() const { return has_configurations_; }
  const robcl::arm::ArmModel& model() const { return model_; }

  /// Clears a fault of the drives and turns the drives on again. Returns when the drives are on and
  /// the brakes are released. Fails with the text of the driver if the drives have a fault, or if
  /// they are not on within `ArmController::Settings::turn_on_time`. Refused while the arm moves.
  /// When `watcher` interrupts the wait, the drives may still turn on.
  tl::expected<void, MoveFailure> reset_drives(MotionWatcher& watcher) {
    return motion_.reset_drives(watcher);
  }

  /// Sets the frame of the arm's base in the world. Fails while the arm moves.
  tl::expected<void, Refused> mount(const Frame& world_from_base);
  /// Sets the frame of the tool, seen from the flange. Fails while the arm moves.
  tl::expected<void, Refused> set_tool_offset(const Frame& flange_from_tool);

  /// Moves the tool to the frame `world_from_goal`. Returns when the measured joint positions show
  /// that the arm has arrived there, or, if the arm goes over into the next move, when the arm is
  /// on the path of that move. A joint move ends in a configuration that `wanted` admits. Without
  /// `wanted`, and on a straight line, the arm keeps its configuration; a straight move to another
  /// configuration is Refused. If `goes_over` is true, the arm need not stop at the goal when the
  /// next move is requested in time.
  tl::expected<void, MoveFailure> move(
      const Frame& world_from_goal, PathKind path, const robcl::motion::Pace& pace,
      MotionWatcher& watcher, const std::optional<robcl::arm::Configuration>& wanted = std::nullopt,
      bool goes_over = false);

  /// Moves all joints to the positions `target`, in rad; the joints arrive at the same time. @pre
  /// `target` has a finite value for each joint.
  tl::expected<void, MoveFailure> move_joints(const JointValues& target,
                                              const robcl::motion::Pace& pace,
                                              MotionWatcher& watcher, bool goes_over = false);

  /// Moves the tool by the corrections of `source`. The motion ends only with a failure, for
  /// example Interrupted when `watcher` interrupts it, or CorrectionsStopped when no more
  /// corrections come. Speeds and accelerations in `limits` that the arm cannot reach are lowered
  /// to the limits of the arm. If the control loop stalls, the loop may still use `source` after
  /// this function has returned.
  tl::expected<void, MoveFailure> follow(robcl::motion::CorrectionAxes axes,
                                         robcl::motion::FollowLimits limits,
                                         std::shared_ptr<robcl::motion::CorrectionSource> source,
                                         MotionWatcher& watcher);

 private:
  const robcl::arm::ArmModel model_;
  const robcl::motion::ToolLimits tool_limits_;
  LabClock clock_;
  ArmController controller_;
  const robcl::motion::Smoothing smoothing_;
  ArmMotion motion_;

  mutable gecos::Mutex reading_;  // never held while waiting
  Frame world_from_base_ GECOS_GUARDED_BY(reading_);
  std::uint64_t pose_epoch_ GECOS_GUARDED_BY(reading_);
  Frame flange_from_tool_ GECOS_GUARDED_BY(reading_);
  const std::unique_ptr<robcl::arm::InverseKinematics> postures_ GECOS_POINTER_GUARDED_BY(reading_);
  const bool has_configurations_;
};

}  // namespace devices
