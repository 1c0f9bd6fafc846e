// The program robcl-world: serves a simulated laboratory. Simulated grippers and sensors ask it for
// the positions of bodies.
#include <chrono>
#include <memory>
#include <sstream>
#include <vector>

#include "devices/support/command_line.hpp"
#include "devices/support/device_main.hpp"
#include "devices/world/gripper_watch.hpp"
#include "devices/world/world_servant.hpp"

namespace {

using namespace std::chrono_literals;

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream in(list);
  for (std::string name; std::getline(in, name, ',');) {
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

int run(int count, char** words) {
  const devices::CommandLine line(
      "robcl-world",
      "Serves a simulated laboratory: a table with a block on it, which grippers can carry.",
      {{"name", "WORLD", "name under which clients find the simulated world"},
       {"grippers", "GRIPPER", "names of the grippers that may carry bodies, separated by commas"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  gecos::Lab lab;
  devices::SimulatedWorld world(devices::demo_floor(), devices::demo_bodies());
  std::vector<std::unique_ptr<devices::GripperWatch>> grippers;
  for (const std::string& name : split(line.text("grippers"))) {
    grippers.push_back(std::make_unique<devices::GripperWatch>(lab, world, name));
  }
  const auto carry = [&grippers] {
    for (const auto& gripper : grippers) gripper->carry();
  };
  devices::WorldServant servant(world, carry, line.clock());
  devices::Served how{.program = "robcl-world",
                      .name = line.text("name"),
                      .clock = line.clock(),
                      .admission = line.admission()};
  for (const auto& gripper : grippers) {
    how.beats.push_back({4ms, [watch = gripper.get()] { watch->tick(); }});
  }
  return devices::serve_device(lab, servant, how);
}

}  // namespace

int main(int count, char** words) {
  return devices::device_main("robcl-world", [&] { return run(count, words); });
}
