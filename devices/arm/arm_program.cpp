#include "arm/arm_program.hpp"

#include <chrono>
#include <cstdio>
#include <string_view>

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
constexpr int usage_error = 2;

int refuse(const std::string& program, const ArmFileError& error) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), to_string(error).c_str());
  return usage_error;
}

std::string in_words(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

std::vector<Option> options(const std::string& name, const std::string& tool_length) {
  return {{"name", name, "name under which clients find the arm"},
          {"tool-length", tool_length, "distance from flange to tool frame along z, mm"},
          {"seed", "1", "seed of the simulated encoder noise"}};
}

std::vector<Option> options(const ArmDescription& arm) {
  return options(arm.name, in_words(robcl::in_mm(arm.tool_offset.position().z())));
}

std::string purpose(const ArmDescription& arm, std::string_view joints) {
  return "Serves a " + std::string(joints) + arm.description + " with a control cycle of 4 ms.";
}

/// A program that serves an arm.
class Serving {
 public:
  /// `connect`: see ArmProgram.
  Serving(std::string program, ArmDescription arm, const CommandLine& line,
          const std::function<std::unique_ptr<JointDriver>()>& connect = {})
      : program_(std::move(program)),
        arm_(std::move(arm)),
        line_(line),
        simulated_(!connect),
        driver_(connect ? connect() : simulated_driver()) {}

  int run_six_axis(const MakeServant& make_servant) {
    SixAxisDevice device(arm_.model, settings(), *driver_);
    const auto servant = make_servant(device, arm_.place);
    return run(device, *servant);
  }

  int run_manipulator() {
    ArmDevice device(arm_.model, settings(), *driver_);
    ManipulatorServant servant(device, arm_.place);
    return run(device, servant);
  }

 private:
  std::unique_ptr<JointDriver> simulated_driver() const {
    SimulatedDriver::Imperfection imperfection;
    imperfection.seed = static_cast<unsigned>(static_cast<long>(line_.number("seed")));
    return std::make_unique<SimulatedDriver>(arm_.start, imperfection);
  }

  ArmDevice::Settings settings() const {
    const double longer = robcl::mm(line_.number("tool-length")) - arm_.tool_offset.position().z();
    ArmDevice::Settings settings;
    settings.tool_limits = arm_.tool_limits;
    settings.tool_offset = robcl::translate(0, 0, longer) * arm_.tool_offset;
    settings.control.cycle = std::chrono::duration<double>(cycle).count();
    return settings;
  }

  int run(ArmDevice& device, ManipulatorServant& servant) const {
    const Periodic control(
        cycle,
        [&](double seconds) {
          device.step(seconds);
          servant.publish();
        },
        [this] { begin_control(); });
    gecos::Lab lab;
    Served how{program_, line_.text("name")};
    how.simulated = simulated_;
    return serve_device(lab, servant, how);
  }

  /// Simulated joints need no punctual control loop, so that for them a warning would be too much.
  void begin_control() const {
    if (const auto missing = make_real_time()) {
      gecos::log(simulated_ ? gecos::LogLevel::Info : gecos::LogLevel::Warning, program_,
                 "the control loop has " + *missing);
    }
  }

  const std::string program_;
  const ArmDescription arm_;
  const CommandLine& line_;
  const bool simulated_;
  const std::unique_ptr<JointDriver> driver_;
};

}  // namespace

int serve_arm(const ArmProgram& program, const MakeServant& make_servant, int count, char** words) {
  const auto arm = parse_arm(program.files);
  if (!arm) return refuse(program.program, arm.error());
  const CommandLine line(program.program, purpose(*arm, program.connect ? "" : "simulated "),
                         options(*arm), count, words);
  if (line.exit_status()) return *line.exit_status();
  return device_main(program.program.c_str(), [&] {
    return Serving(program.program, *arm, line, program.connect).run_six_axis(make_servant);
  });
}

int serve_arm_of_file(int count, char** words) {
  const std::string program = "robcl-arm";
  const std::string operand = "ARM.toml";
  if (count < 2 || words[1][0] == '-') {
    const std::string of_file = "that of " + operand;
    const bool help =
        count > 1 && (words[1] == std::string_view("--help") || words[1] == std::string_view("-h"));
    CommandLine line(program,
                     "Serves the arm that the file " + operand +
                         " describes, with simulated joints and a control cycle of 4 ms.",
                     options(of_file, of_file), help ? 2 : 1, words, operand);
    if (!help) line.refuse("the first argument must be the TOML file of an arm");
    return *line.exit_status();
  }
  const auto arm = read_arm(words[1]);
  if (!arm) return refuse(program, arm.error());
  const CommandLine line(program, purpose(*arm, "simulated "), options(*arm), count - 1, words + 1,
                         operand);
  if (line.exit_status()) return *line.exit_status();
  return device_main(program.c_str(), [&] {
    Serving serving(program, *arm, line);
    if (arm->model.axes() != 6) return serving.run_manipulator();
    return serving.run_six_axis([](SixAxisDevice& device, std::string place) {
      return std::make_unique<SixAxisServant>(device, std::move(place));
    });
  });
}

}  // namespace devices
