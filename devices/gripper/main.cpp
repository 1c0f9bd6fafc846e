// The program robcl-gripper: serves a gripper with two simulated jaws on the flange of an arm.
#include <chrono>
#include <cstdio>

#include "devices/gripper/gripper_servant.hpp"
#include "devices/support/command_line.hpp"
#include "devices/support/device_main.hpp"
#include "devices/support/periodic.hpp"

namespace {

using namespace std::chrono_literals;

int run(int count, char** words) {
  const devices::CommandLine line(
      "robcl-gripper",
      "Serves a simulated gripper whose two parallel jaws grip bodies of the simulated world.",
      {{"name", "GRIPPER", "name under which clients find the gripper"},
       {"world", "WORLD", "name of the simulated world that has the bodies; '' for none"},
       {"carrier", "RX90", "arm whose flange carries the gripper; '' for none"},
       {"length", "150", "distance from the base of the gripper to the point between its jaws, mm"},
       {"max-width", "110", "greatest distance between the jaws, mm"},
       {"max-force", "100", "greatest grip force, N"},
       {"speed", "150", "speed at which the distance between the jaws changes, mm/s"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  devices::SimulatedGripper::Settings settings;
  settings.max_width = robcl::mm(line.number("max-width"));
  settings.max_force = line.number("max-force");
  settings.speed = robcl::mm(line.number("speed"));
  if (settings.max_width <= 0 || settings.max_force <= 0 || settings.speed <= 0) {
    std::fputs("robcl-gripper: --max-width, --max-force and --speed must be above 0\n", stderr);
    return 2;
  }
  gecos::Lab lab;
  devices::GripperServant servant(lab, line.text("name"), line.text("world"), line.text("carrier"),
                                  robcl::translate(0, 0, robcl::mm(line.number("length"))),
                                  settings);
  devices::LabClock clock(line.clock());
  const devices::Periodic jaws(clock, 5ms, [&servant](double seconds) { servant.step(seconds); });
  return devices::serve_device(lab, servant,
                               {.program = "robcl-gripper",
                                .name = line.text("name"),
                                .clock = clock.speed(),
                                .admission = line.admission(),
                                .blocking = true,  // handlers wait for the world
                                .beats = {{20ms, [&servant] { servant.publish(); }}}});
}

}  // namespace

int main(int count, char** words) {
  return devices::device_main("robcl-gripper", [&] { return run(count, words); });
}
