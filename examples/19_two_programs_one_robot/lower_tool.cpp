// Lowers the tool towards the block, under a status that programs share which know the password.
// When `guard` takes over, the motion ends, and this program waits until it may command again.
// Where the robot is in a zone, the motion also ends when nobody is present any more
// (`hold_button`).

#include <algorithm>
#include <chrono>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main(int argc, char** argv) {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  const auto lease = gecos::actor(*robot, argc > 1 ? argv[1] : "");
  if (!lease) return fail(lease.error());  // without the password: says who holds the robot

  // z points down
  const auto start = robcl::Frame::from_euler_zyz(500_mm, 200_mm, 300_mm, 0_deg, 180_deg, 0_deg);
  const auto moved = robot->move(start).get();
  if (!moved) return fail(moved.error());
  std::cout << "lowering the tool" << std::endl;
  const auto lowered =
      robot->move(start * robcl::translate(0, 0, 200_mm), robcl::Trajectory{.tool_speed = 0.05});
  if (const auto end = lowered.get(); !end) std::cout << end.error() << std::endl;
  if (const auto end = robot->move(start).get(); !end) std::cout << end.error() << std::endl;

  auto told = gecos::roster(*robot).get();
  while (told && std::ranges::any_of(told->holders, &gecos::Holder::taken_over)) {
    told = gecos::roster(*robot, told->newest, std::chrono::hours(1)).get();  // waits for a change
  }
  if (!told) return fail(told.error());
  // Nothing resumes by itself: this is a new command.
  const auto again = robot->move(start).get();
  if (!again) return fail(again.error());
  std::cout << "at the start again" << std::endl;
}
