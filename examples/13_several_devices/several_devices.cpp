// Lowers the arm, opens the gripper and measures a distance, all at once and in one thread.

#include <poll.h>

#include <iostream>
#include <map>
#include <string_view>
#include <vector>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/gripper_client.hpp"
#include "robcl/laser_distance_sensor_client.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;

// Tool frames in the world: z points down, so the second one is 60 mm below the first.
const robcl::Frame start =
    robcl::Frame::from_euler_zyz(500_mm, 200_mm, 250_mm, 0_deg, 180_deg, 0_deg);
const robcl::Frame goal = start * robcl::translate(0, 0, 60_mm);

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main() {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  auto gripper = lab.create<robcl::Gripper>("GRIPPER");
  if (!gripper) return fail(gripper.error());
  auto laser = lab.create<robcl::LaserDistanceSensor>("LDS");
  if (!laser) return fail(laser.error());
  const auto robot_lease = gecos::actor(*robot);
  if (!robot_lease) return fail(robot_lease.error());
  const auto gripper_lease = gecos::actor(*gripper);
  if (!gripper_lease) return fail(gripper_lease.error());
  const auto at_start = robot->move(start).get();
  if (!at_start) return fail(at_start.error());

  const auto lower = robot->move(goal, {{.tool_speed = 0.03}});  // m/s: 2 s
  const auto open = gripper->open(100_mm);
  const auto look = laser->measure();
  std::map<int, std::string_view> running{
      {lower.descriptor(), "lower"}, {open.descriptor(), "open"}, {look.descriptor(), "look"}};
  while (!running.empty()) {
    std::vector<pollfd> ends;
    for (const auto& [descriptor, what] : running) ends.push_back({descriptor, POLLIN, 0});
    if (poll(ends.data(), ends.size(), -1) < 0) return fail("poll");
    for (const pollfd& end : ends) {
      if (end.revents == 0) continue;
      std::cout << running[end.fd] << " has ended" << std::endl;
      running.erase(end.fd);
    }
  }
  return lower.get() && open.get() && look.get() ? 0 : 1;
}
