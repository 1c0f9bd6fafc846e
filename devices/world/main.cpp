// robcl-world: the simulated laboratory that grippers and sensors ask what is where.
#include <chrono>
#include <cstdio>
#include <memory>
#include <sstream>
#include <vector>

#include "command_line/command_line.hpp"
#include "gecos/gecos.hpp"
#include "periodic/periodic.hpp"
#include "world/gripper_watch.hpp"
#include "world/world_servant.hpp"

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

}  // namespace

int main(int count, char** words) {
  const devices::CommandLine line(
      "robcl-world",
      "Serves a simulated laboratory: a table with a block on it, which grippers can carry.",
      {{"name", "WORLD", "name to register"},
       {"grippers", "GRIPPER",
        "names of the grippers that may carry something, with commas between"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  gecos::Lab lab;
  devices::SimulatedWorld world(devices::demo_floor(), devices::demo_bodies());
  std::vector<std::unique_ptr<devices::GripperWatch>> grippers;
  for (const std::string& name : split(line.text("grippers"))) {
    grippers.push_back(std::make_unique<devices::GripperWatch>(lab, world, name));
  }
  devices::WorldServant servant(world, [&grippers] {
    for (const auto& gripper : grippers) gripper->carry();
  });
  gecos::Server server(lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  if (const auto served = server.add(line.text("name"), servant, options); !served) {
    std::fprintf(stderr, "robcl-world: %s\n", served.error().text.c_str());
    return 1;
  }
  std::vector<std::unique_ptr<devices::Periodic>> tending;
  for (const auto& gripper : grippers) {
    tending.push_back(std::make_unique<devices::Periodic>(
        4ms, [watch = gripper.get()](double) { watch->tend(); }));
  }
  std::printf("robcl-world: %s is ready\n", line.text("name").c_str());
  std::fflush(stdout);
  server.run();
  return 0;
}
