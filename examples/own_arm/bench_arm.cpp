// The program bench-arm: serves the bench arm. Its argument is the file bench.toml.
#include <algorithm>
#include <memory>

#include "devices/arm/arm_program.hpp"
#include "pretend_drives.hpp"
#include "workshop/bench_arm_server.hpp"

namespace {

using devices::DrivePower;
using devices::DriverFault;
using devices::JointState;
using devices::JointValues;

class BenchDrives final : public devices::JointDriver {
 public:
  explicit BenchDrives(const JointValues& start) : drives_(from(start)) {}

  tl::expected<JointState, DriverFault> read() override {
    JointState state{.power = drives_.on() ? DrivePower::On : DrivePower::Off};
    state.position = Eigen::Map<const JointValues>(drives_.joints().data(), 6);
    state.fault = drives_.fault();
    if (!state.fault.empty()) state.power = DrivePower::Fault;
    return state;
  }
  tl::expected<void, DriverFault> write(const devices::JointCommand& command, double) override {
    drives_.go_to(from(command.position));
    return {};
  }
  tl::expected<void, DriverFault> enable() override {
    if (!drives_.turn_on()) return tl::unexpected(DriverFault{drives_.fault()});
    return {};
  }
  tl::expected<void, DriverFault> disable() override {
    drives_.turn_off();
    return {};
  }
  tl::expected<void, DriverFault> reset() override {
    drives_.clear_fault();
    return {};
  }

 private:
  static PretendDrives::Joints from(const JointValues& values) {
    PretendDrives::Joints joints;
    std::copy_n(values.data(), joints.size(), joints.begin());
    return joints;
  }

  PretendDrives drives_;
};

class BenchArm final : public workshop::BenchArmServant, public devices::SixAxisServant {
 public:
  using devices::SixAxisServant::SixAxisServant;

 private:
  gecos::Result<void> reset_drives(gecos::Execution<>& run) override { return restart_drives(run); }
};

}  // namespace

int main(int count, char** words) {
  const auto connect = [](const devices::ArmDescription& arm) {
    return std::make_unique<BenchDrives>(arm.start);
  };
  return devices::serve_arm<BenchArm>({.program = "bench-arm", .connect = connect}, count, words);
}
