// Bounds how long a motion may take: by a deadline, which ends the motion, or by one's own
// patience, which leaves it running.

#include <chrono>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;
using namespace std::chrono_literals;

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
  const auto here = robot->tool().get();
  if (!here) return fail(here.error());
  const robcl::Frame above = robcl::translate(0, 0, 100_mm) * *here;
  const robcl::Trajectory slowly{.tool_speed = 0.02};  // m/s: 5 s

  const auto late = gecos::with(*robot, {.deadline = 1s}).move(above, slowly).get();
  std::cout << "deadline of 1 s: " << late.error() << std::endl;  // the arm stands

  const auto never = gecos::with(*robot, {.deadline = 0s}).move(above, slowly).get();
  std::cout << "deadline of 0 s: " << never.error() << std::endl;  // was not sent

  const auto move = robot->move(above, slowly);
  std::cout << "patience of 1 s: " << move.wait_for(1s) << std::endl;  // the arm moves on
  const auto moved = move.get();
  if (!moved) return fail(moved.error());
  std::cout << "in the end: " << move.state() << std::endl;
}
