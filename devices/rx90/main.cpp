// robcl-rx90: a simulated Staeubli RX90.
#include <chrono>
#include <cstdio>

#include "command_line/command_line.hpp"
#include "gecos/gecos.hpp"
#include "kdl/simulated_driver.hpp"
#include "periodic/periodic.hpp"
#include "rx90/rx90_servant.hpp"
#include "rx90/rx90_urdf.hpp"

namespace {

using namespace std::chrono_literals;

constexpr auto cycle = 4ms;
constexpr double seconds_to_full_speed = 0.25;  // of each joint; no published source gives it

/// In front of the arm, tool down: far from every singularity.
devices::JointValues ready() {
  devices::JointValues joints(6);
  joints << 0, robcl::deg(-20), robcl::deg(110), 0, robcl::deg(90), 0;
  return joints;
}

int fail(const std::string& what) {
  std::fprintf(stderr, "robcl-rx90: %s\n", what.c_str());
  return 1;
}

}  // namespace

int main(int count, char** words) {
  const devices::CommandLine line(
      "robcl-rx90", "Serves a simulated Staeubli RX90 with a control cycle of 4 ms.",
      {{"name", "RX90", "name to register"},
       {"tool-length", "150", "from the flange to the tool frame, along z, mm"},
       {"seed", "1", "of the encoders' noise"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  const auto model =
      robcl::arm::ArmModel::from_urdf(devices::rx90_urdf, "foot", "flange", seconds_to_full_speed);
  if (!model) return fail(model.error().text);
  devices::SimulatedDriver::Imperfection imperfection;
  imperfection.seed = static_cast<unsigned>(line.number("seed"));
  devices::SimulatedDriver driver(ready(), imperfection);
  devices::KdlManipulator::Settings settings;
  settings.tool_offset = robcl::translate(0, 0, robcl::mm(line.number("tool-length")));
  devices::KdlSixAxis arm(*model, settings, driver);
  const devices::Periodic control(cycle, [&arm](double seconds) { arm.step(seconds); });

  gecos::Lab lab;
  devices::Rx90Servant servant(arm);
  gecos::Server server(lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  if (const auto served = server.add(line.text("name"), servant, options); !served) {
    return fail(served.error().text);
  }
  const devices::Periodic publishing(cycle, [&servant](double) { servant.publish(); });
  std::printf("robcl-rx90: %s is ready\n", line.text("name").c_str());
  std::fflush(stdout);
  server.run();
  return 0;
}
