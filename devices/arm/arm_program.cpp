#include "devices/arm/arm_program.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <vector>

#include "devices/drivers/simulated_driver.hpp"
#include "devices/support/command_line.hpp"
#include "devices/support/device_main.hpp"
#include "devices/support/periodic.hpp"
#include "devices/support/real_time.hpp"
#include "gecos/base/log.hpp"

namespace devices {
namespace {

constexpr int usage_error = 2;
constexpr const char* operand = "ARM.toml";

int refuse(const std::string& program, const ArmFileError& error) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), to_string(error).c_str());
  return usage_error;
}

std::string in_words(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

std::vector<Option> options(const ArmProgram& program, const std::string& name,
                            const std::string& tool_length) {
  std::vector<Option> all{
      {"name", name, "name under which clients find the arm"},
      {"tool-length", tool_length, "distance from flange to tool frame along z, mm"}};
  if (program.connect) return all;
  all.push_back({"seed", "1", "seed of the simulated encoder noise"});
  all.push_back({"noise", "0.4", "standard deviation of the simulated encoder noise, counts"});
  return all;
}

CommandLine read_line(const ArmProgram& program, const ArmDescription& arm, int count,
                      char** words) {
  const std::string purpose =
      program.connect ? "Serves a " + arm.description + "."
                      : "Serves a simulated " + arm.description + " with a control cycle of 4 ms.";
  return {program.program,
          purpose,
          options(program, arm.name, in_words(robcl::in_mm(arm.tool_offset.position().z()))),
          count,
          words,
          program.files ? "" : operand};
}

/// Handles a command line that does not begin with a TOML file: prints the help or an error, and
/// returns the exit status.
int ask_for_file(const ArmProgram& program, int count, char** words) {
  const std::string of_file = std::string("that of ") + operand;
  const std::string joints =
      program.connect ? "." : ", with simulated joints and a control cycle of 4 ms.";
  const bool help =
      count > 1 && (words[1] == std::string_view("--help") || words[1] == std::string_view("-h"));
  CommandLine line(program.program,
                   std::string("Serves the arm that the file ") + operand + " describes" + joints,
                   options(program, of_file, of_file), help ? 2 : 1, words, operand);
  if (!help) line.refuse("the first argument must be the TOML file of an arm");
  return *line.exit_status();
}

/// A program that serves an arm.
class Serving {
 public:
  Serving(const ArmProgram& program, const ArmDescription& arm, const CommandLine& line)
      : program_(program), arm_(arm), line_(line), driver_(make_driver()) {}

  int run(const MakeServant& make_servant) {
    ArmDevice device(arm_.model, settings(), *driver_);
    const auto servant = make_servant(device, arm_.place);
    const Periodic control(
        device.clock(),
        std::chrono::round<gecos::Duration>(std::chrono::duration<double>(device.cycle())),
        [&](double seconds) {
          device.step(seconds);
          servant->publish();
        },
        [this] { begin_control(); });
    gecos::Lab lab;
    Served how{program_.program, line_.text("name")};
    how.simulated = simulated();
    how.clock = line_.clock();
    how.admission = line_.admission();
    return serve_device(lab, *servant, how);
  }

 private:
  bool simulated() const { return !program_.connect; }

  std::unique_ptr<JointDriver> make_driver() const {
    if (!simulated()) return program_.connect(arm_);
    SimulatedDriver::Imperfection imperfection;
    imperfection.seed = static_cast<unsigned>(static_cast<long>(line_.number("seed")));
    imperfection.noise = std::max(line_.number("noise"), 0.0);
    return std::make_unique<SimulatedDriver>(arm_.start, imperfection);
  }

  ArmDevice::Settings settings() const {
    const double longer = robcl::mm(line_.number("tool-length")) - arm_.tool_offset.position().z();
    ArmDevice::Settings settings;
    settings.tool_limits = arm_.tool_limits;
    settings.seconds_to_full_acceleration = arm_.seconds_to_full_acceleration;
    settings.tool_offset = robcl::translate(0, 0, longer) * arm_.tool_offset;
    settings.clock_speed = line_.clock();
    return settings;
  }

  /// Prepares the thread of the control loop. A control loop in real time gets a real-time
  /// priority. If the system does not permit this priority, logs a warning; for simulated joints,
  /// which need no punctual loop, logs only a message of the level Info. A simulation at another
  /// speed than real time gets no real-time priority, because it may use a whole core and would
  /// take this core from other programs.
  void begin_control() const {
    if (line_.clock() != 1) return;
    if (const auto missing = make_real_time()) {
      gecos::log(simulated() ? gecos::LogLevel::Info : gecos::LogLevel::Warning, program_.program,
                 "the control loop has " + *missing);
    }
  }

  const ArmProgram& program_;
  const ArmDescription& arm_;
  const CommandLine& line_;
  const std::unique_ptr<JointDriver> driver_;
};

}  // namespace

int serve_arm(const ArmProgram& program, const MakeServant& make_servant, int count, char** words) {
  const int operands = program.files ? 0 : 1;
  if (operands > 0 && (count < 2 || words[1][0] == '-')) return ask_for_file(program, count, words);
  const auto arm = program.files ? parse_arm(*program.files) : read_arm(words[1]);
  if (!arm) return refuse(program.program, arm.error());
  CommandLine line = read_line(program, *arm, count - operands, words + operands);
  if (!line.exit_status() && program.connect) {
    line.need_real_time("the joints of " + line.text("name") + " are real");
  }
  if (line.exit_status()) return *line.exit_status();
  return device_main(program.program.c_str(),
                     [&] { return Serving(program, *arm, line).run(make_servant); });
}

int serve_arm(const ArmProgram& program, int count, char** words) {
  const MakeServant make = [](ArmDevice& arm,
                              std::string place) -> std::unique_ptr<ManipulatorServant> {
    if (arm.model().axes() == 6) return std::make_unique<SixAxisServant>(arm, std::move(place));
    return std::make_unique<ArticulatedArmServant>(arm, std::move(place));
  };
  return serve_arm(program, make, count, words);
}

}  // namespace devices
