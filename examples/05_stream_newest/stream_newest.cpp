// Watches the tool while the arm lowers it. The arm publishes 250 samples a second; this program
// looks five times a second, and each time gets the newest one.

#include <chrono>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;
using namespace std::chrono_literals;

// Tool frames in the world: z points down, so the second one is 100 mm below the first.
const robcl::Frame start =
    robcl::Frame::from_euler_zyz(500_mm, 200_mm, 250_mm, 0_deg, 180_deg, 0_deg);
const robcl::Frame goal = start * robcl::translate(0, 0, 100_mm);

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main() {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  const auto lease = gecos::actor(*robot);
  if (!lease) return fail(lease.error());
  const auto at_start = robot->move(start).get();
  if (!at_start) return fail(at_start.error());
  auto tool = robot->tool(gecos::stream);
  if (!tool) return fail(tool.error());

  const robcl::Trajectory slowly{.tool_speed = 0.08};  // m/s
  const auto move = robot->move(goal, slowly);
  while (move.wait_for(200ms) == gecos::State::Running) {
    const auto newest = tool->latest();  // never waits; nothing once the server is lost
    if (!newest) continue;
    const std::chrono::duration<double, std::milli> age = newest->age;
    std::cout << "tool at " << robcl::in_mm(newest->value.z()) << " mm, " << age.count()
              << " ms ago; " << newest->lost << " samples skipped" << std::endl;
  }
  const auto moved = move.get();
  return moved ? 0 : fail(moved.error());
}
