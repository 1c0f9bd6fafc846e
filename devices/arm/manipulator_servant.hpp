#pragma once

#include <string>

#include "devices/arm/arm_device.hpp"
#include "devices/arm/follow_call.hpp"
#include "devices/arm/next_configuration.hpp"
#include "gecos/base/mutex.hpp"
#include "robcl/manipulator_server.hpp"

namespace devices {

/// Implements the operations of the interface `robcl::Manipulator` with an ArmDevice. Thread-safe.
///
/// The servant of an arm with an interface of its own derives from two classes: the generated
/// servant class of that interface, and one of ManipulatorServant, SixAxisServant and
/// ArticulatedArmServant. The servant implements only the operations that its interface adds.
class ManipulatorServant : public virtual robcl::ManipulatorServant {
 public:
  /// `place` says where the arm stands, for example "an RX90 weighs 111 kg and stands on the
  /// floor". A call of `mount` with a carrier fails with an error that begins with `place`.
  ManipulatorServant(ArmDevice& arm, std::string place) : arm_(arm), place_(std::move(place)) {
    alter().need_command();
  }

  /// Sends a sample on each stream of the arm if there is a new measurement, and refuses the
  /// samples of `alter` while no `follow` runs. Only one thread at a time may call this method. The
  /// control loop calls it after each cycle, so that samples are as new as possible. Therefore the
  /// method takes only locks that other threads hold briefly, and does not allocate after the first
  /// samples.
  void publish();

 protected:
  using Progress = gecos::Execution<robcl::MotionProgress>;

  ArmDevice& arm() { return arm_; }

  /// Clears a fault of the drives and turns the drives on again. A servant calls this method in an
  /// operation that its interface adds to Manipulator. Returns when the drives are on, when they
  /// have a fault, after 10 s, or when `run` is interrupted.
  gecos::Result<void> restart_drives(gecos::Execution<>& run);

  /// Sends the measurements of `sample` on the streams of the interface Manipulator. The servant of
  /// an interface that has more streams must override this method; the new method must also call
  /// this one.
  virtual void publish_sample(const ArmDevice::Sample& sample);

  gecos::Result<Frame> base() override { return arm_.base(); }
  gecos::Result<std::string> parent() override { return std::string(); }
  gecos::Result<void> mount(const std::string& carrier, const Frame& offset) override;
  gecos::Result<Frame> tool() override { return arm_.sample().tool; }
  gecos::Result<Frame> flange() override { return arm_.sample().flange; }
  gecos::Result<robcl::Configuration> posture() override;
  gecos::Result<Frame> tool_offset() override { return arm_.tool_offset(); }
  gecos::Result<void> set_tool_offset(const Frame& value) override;
  gecos::Result<std::uint64_t> pose_epoch() override { return arm_.pose_epoch(); }
  gecos::Result<void> move(const Frame& goal, const std::optional<robcl::Trajectory>& how,
                           const std::optional<std::uint64_t>& pose_epoch, Progress& run) override;
  gecos::Result<void> set_configuration(const robcl::Configuration& wanted,
                                        gecos::Execution<>& run) override;
  gecos::Result<void> follow(robcl::FollowMode axes,
                             const std::optional<robcl::FollowLimits>& limits,
                             FollowCall::Progress& run) override;
  gecos::Result<void> override_speed(double factor) override {
    arm_.set_override(factor);
    return {};
  }
  gecos::Result<double> speed_override() override { return arm_.speed_override(); }
  gecos::Result<bool> standing() override { return !arm_.moving(); }
  gecos::Result<std::uint64_t> missed_cycles() override { return arm_.missed_cycles(); }
  gecos::Result<double> cycle() override { return arm_.cycle(); }
  gecos::Result<double> braking_time() override { return arm_.braking_time(); }
  gecos::Result<double> clock_speed() override { return arm_.clock().speed(); }
  gecos::Result<double> reached_clock_speed() override { return arm_.clock().reached(); }

 private:
  ArmDevice& arm_;
  const std::string place_;
  NextConfiguration next_configuration_;
  gecos::Mutex following_;       // held by the handler of `follow`, which reads `alter`
  bool moved_ = false;           // whether the last published sample was of a moving arm
  std::uint64_t published_ = 0;  // number of the last published measurement
};

}  // namespace devices
