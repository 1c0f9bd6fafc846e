#include "arm/arm_program.hpp"

#include <chrono>

#include "drivers/simulated_driver.hpp"
#include "gecos/base/log.hpp"
#include "support/command_line.hpp"
#include "support/device_main.hpp"
#include "support/periodic.hpp"
#include "support/real_time.hpp"

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr auto cycle = 4ms;

JointValues in_radians(const std::vector<double>& degrees) {
  JointValues joints(static_cast<Eigen::Index>(degrees.size()));
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    joints[static_cast<Eigen::Index>(i)] = robcl::deg(degrees[i]);
  }
  return joints;
}

std::unique_ptr<JointDriver> simulated(const ArmProgram& program, const CommandLine& line) {
  SimulatedDriver::Imperfection imperfection;
  imperfection.seed = static_cast<unsigned>(line.number("seed"));
  return std::make_unique<SimulatedDriver>(in_radians(program.start_degrees), imperfection);
}

/// Simulated joints need no punctual control loop, so that for them a warning would be too much.
void begin_control(const ArmProgram& program) {
  if (const auto missing = make_real_time()) {
    gecos::log(program.connect ? gecos::LogLevel::Warning : gecos::LogLevel::Info, program.program,
               "the control loop has " + *missing);
  }
}

int run(const ArmProgram& program, const MakeServant& make_servant, const CommandLine& line) {
  auto model = robcl::arm::ArmModel::from_urdf(program.urdf, program.base_link, program.flange_link,
                                               program.seconds_to_full_speed);
  if (model && !program.front_degrees.empty()) {
    model = model->with_front(in_radians(program.front_degrees));
  }
  if (!model) return fail(program.program, model.error().text);
  const auto driver = program.connect ? program.connect() : simulated(program, line);
  ArmDevice::Settings settings;
  settings.tool_offset = robcl::translate(0, 0, robcl::mm(line.number("tool-length")));
  settings.control.cycle = std::chrono::duration<double>(cycle).count();
  SixAxisDevice arm(*model, settings, *driver);
  const auto servant = make_servant(arm, program.place);
  const Periodic control(
      cycle,
      [&](double seconds) {
        arm.step(seconds);
        servant->publish();
      },
      [&program] { begin_control(program); });

  gecos::Lab lab;
  Served how{program.program, line.text("name")};
  how.simulated = !program.connect;
  return serve_device(lab, *servant, how);
}

}  // namespace

int serve_arm(const ArmProgram& program, const MakeServant& make_servant, int count, char** words) {
  const CommandLine line(program.program,
                         (program.connect ? "Serves a " : "Serves a simulated ") + program.arm +
                             " with a control cycle of 4 ms.",
                         {{"name", program.name, "name under which clients find the arm"},
                          {"tool-length", "150", "distance from flange to tool frame along z, mm"},
                          {"seed", "1", "seed of the simulated encoder noise"}},
                         count, words);
  if (line.exit_status()) return *line.exit_status();
  return device_main(program.program.c_str(), [&] { return run(program, make_servant, line); });
}

}  // namespace devices
