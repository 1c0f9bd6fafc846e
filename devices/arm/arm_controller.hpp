// The part of an arm's server that runs once per cycle of the control loop.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <semaphore>

#include "devices/arm/latest.hpp"
#include "devices/drivers/supervised_driver.hpp"
#include "gecos/base/clock.hpp"
#include "robcl/arm/kinematics.hpp"
#include "robcl/motion/trajectory_generator.hpp"

namespace devices {

/// Runs one motion at a time, and holds the arm's position when no motion runs. Only the control
/// loop's thread may call `step`. Unless the driver fails, `step` neither locks nor allocates. Any
/// thread may call `now`. Only the thread that moves the arm may call the other methods.
///
/// The constructor enables the drives. If the drives follow velocities, the control loop controls
/// the joint positions. A fault of the drives ends the motion. The fault lasts until `reset_drives`
/// is called, so that the arm does not start to move when the cause of the fault disappears.
///
/// This class has more members than other classes. Half of the members pass commands from the
/// thread that moves the arm to the thread of the control loop, or results back. The separation of
/// these two threads is the purpose of the class.
class ArmController {
 public:
  struct Settings {
    double settled = 1e-4;  ///< rad: a joint that is this close to its goal counts as arrived
    double settle_time =
        1;  ///< time in s, after the end of a plan, in which all joints must arrive
    double position_gain = 20;  ///< rad/s per rad of position error, in velocity mode
    double turn_on_time = 10;   ///< time in s in which the drives must be on after a reset
  };

  /// The measurements of one cycle.
  struct Reading {
    std::array<double, robcl::arm::max_axes> joints{};
    std::array<double, robcl::arm::max_axes> commanded{};  // set points in that cycle, rad
    std::array<double, 7> base_from_flange{};              // x, y, z, then quaternion w, x, y, z
    double fraction = 0;
    double remaining = 0;
    std::uint64_t cycle = 0;          // number of measurements so far
    std::uint64_t missed = 0;         // number of control cycles that were missed so far
    std::uint64_t motion = 0;         // number of the motion that runs or ran last
    std::int64_t measured_at_ns = 0;  // time of the Unix clock
    bool moving = false;
    DrivePower power = DrivePower::Off;
  };

  /// How a motion, or a reset of the drives, ended.
  enum class End { Arrived, Stopped, NotSettled, Fault };
  struct Outcome {
    End end = End::Arrived;
    Eigen::Index axis = 0;  ///< after NotSettled: index of the joint furthest from its goal
    double away = 0;        ///< rad, distance of that joint from its goal
    DriverFault fault;      ///< after Fault: what failed
  };

  /// Throws std::runtime_error with the driver's message if the driver cannot read the joint
  /// positions, or if it reads a different number of joint positions than the model has joints.
  /// Throws std::invalid_argument if the period of the driver is not above 0, or longer than 0.1 s.
  ArmController(const robcl::arm::ArmModel& model, const Settings& settings, JointDriver& driver);
  /// Turns the drives off, so that the brakes hold the arm.
  ~ArmController();
  ArmController(const ArmController&) = delete;
  ArmController& operator=(const ArmController&) = delete;

  /// Runs one control cycle. `seconds` is the time since the previous cycle: `cycle()`, or a
  /// multiple of `cycle()` after missed cycles.
  ///
  /// A missed cycle delays the motion by one cycle. The motion does not catch up, because two
  /// successive set points may differ only by the distance that a joint may move in one cycle.
  /// After more than `most_delayed` missed cycles in a row, the joints have stopped at the last set
  /// point, and the motion starts again from rest on its path. If a joint is then further from the
  /// last set point than it moves in 20 ms at full speed, the drives did not hold it: the motion
  /// ends as a Fault.
  void step(double seconds);
  static constexpr std::uint64_t most_delayed = 5;

  /// Returns the number of control cycles that have started. The number does not rise while a call
  /// of the driver blocks.
  std::uint64_t beats() const { return beats_.load(); }

  /// Hands a motion to the control loop. @pre `wait` returned the outcome of the last motion, and
  /// `generator` starts at the joint positions `standing_at()`. Until `wait` returns the outcome of
  /// this motion, other threads may call only those functions of `generator` whose comments say
  /// that any thread may call them. Returns the number of the motion.
  std::uint64_t start(std::shared_ptr<robcl::motion::TrajectoryGenerator> generator);
  /// Makes the control loop clear a fault of the drives, enable the drives, and wait until the
  /// drives are on and the brakes are released. `wait` returns the outcome: Arrived, or a Fault if
  /// the drives have a fault or are not on in time. @pre `wait` returned the outcome of the last
  /// motion.
  void reset_drives();
  /// Decelerates the running motion until the arm stands, or ends a running reset of the drives.
  /// May be called at any time, even when no motion runs.
  void stop() { stop_.store(true); }
  /// Scales the speed of this and all later motions from the next cycle on. `factor` is from 0 to
  /// 1; 0 pauses a motion on its path. May be called at any time.
  void set_override(double factor) { override_.store(factor); }
  double speed_override() const { return override_.load(); }
  /// Waits at most `patience` for the end of the motion, and returns its outcome; nullopt if the
  /// motion still runs. The next motion may start after `wait` has returned an outcome.
  std::optional<Outcome> wait(gecos::Duration patience);

  /// Returns the set points that the joints hold while no motion runs. They are the end of the last
  /// motion or, after a fault of the driver, the measured joint positions.
  JointValues standing_at() const;
  double cycle() const { return drives_.period; }  ///< s
  Reading now() const { return reading_.read(); }

 private:
  enum class Phase { Standing, Moving, Settling, TurningOn };

  void stay_here();
  void enable();
  void begin();
  void begin_reset();
  void begin_motion();
  void move(std::uint64_t missed);
  JointCommand command_for(const JointValues& before) const;
  std::optional<DriverFault> fault_of(const tl::expected<JointState, DriverFault>& answer,
                                      double seconds) const;
  std::optional<DriverFault> not_held(const JointValues& measured, const JointValues& held) const;
  std::optional<Outcome> turn_on(const tl::expected<JointState, DriverFault>& answer,
                                 double seconds);
  void take(tl::expected<JointState, DriverFault> answer, bool motion_failed);
  void end_motion(Outcome outcome);
  std::optional<Outcome> settle(const JointValues& measured, double seconds);
  void publish();

  const Settings settings_;
  const Eigen::Index axes_;
  const JointDriver::Properties drives_;
  SupervisedDriver driver_;
  robcl::arm::Kinematics forward_;
  /// The limits of all joints.
  struct Limits {
    JointValues speeds;         ///< rad/s
    JointValues accelerations;  ///< rad/s^2
  };
  const Limits limits_;

  // From the call of start() or reset_drives() to the outcome, only the control loop uses
  // generator_, motion_ and outcome_. At other times, only the thread that moves the arm uses them.
  std::shared_ptr<robcl::motion::TrajectoryGenerator> generator_;  // null: a reset of the drives
  std::uint64_t motion_ = 0;  // number of the motion in generator_
  Outcome outcome_;

  std::atomic<bool> started_{false};     // publishes generator_ to the loop
  std::atomic<bool> stop_{false};        // orders no other memory
  std::atomic<double> override_{1};      // orders no other memory
  std::atomic<std::uint64_t> beats_{0};  // orders no other memory
  std::counting_semaphore<> ended_{0};   // publishes outcome_ to the waiting thread

  /// The state that only the thread of the control loop uses.
  struct Loop {
    Phase phase = Phase::Standing;
    JointState state;  ///< the driver's last answer
    JointValues command{};
    JointValues velocity{};  ///< rad/s, of the last command
    bool threw = false;      ///< the generator of the set points has thrown an exception
    bool silent = false;     ///< the driver returned no plausible answer in the last cycle
    std::string refusal{};   ///< why the drives could not be enabled; empty if they could
    double settling = 0;     ///< time in s since the end of the plan, or since the reset
    int arrived = 0;         ///< consecutive cycles in which all joints were at their goal
    Reading last{};
  };
  Loop loop_;
  Latest<Reading> reading_;
};

}  // namespace devices
