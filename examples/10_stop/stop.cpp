// Stops a robot that another program moves. Stopping needs no status: `gecos stop RX90` at a
// terminal does the same.

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
  gecos::Lab mover_lab;
  auto robot = mover_lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  auto lease = gecos::actor(*robot);
  if (!lease) return fail(lease.error());
  const auto here = robot->tool().get();
  if (!here) return fail(here.error());
  const robcl::Trajectory slowly{.tool_speed = 0.02};  // m/s
  const auto move = robot->move(robcl::translate(0, 0, 100_mm) * *here, slowly);
  while (move.progress().fraction < 0.1 && move.wait_for(50ms) == gecos::State::Running) {
  }

  gecos::Lab bystander_lab;  // a session of its own, as another program has; it holds no status
  auto same_robot = bystander_lab.create<robcl::Manipulator>("RX90");
  if (!same_robot) return fail(same_robot.error());
  if (const auto stopped = gecos::stop(*same_robot).get(); !stopped) return fail(stopped.error());

  std::cout << "the move: " << move.get().error() << std::endl;
  std::cout << "the next: " << robot->move(*here).get().error() << std::endl;  // the lease is over
  lease = gecos::actor(*robot);  // who knows that the robot may move again acquires it anew
  if (!lease) return fail(lease.error());
  const auto back = robot->move(*here).get();
  if (!back) return fail(back.error());
  std::cout << "with a new lease: moved" << std::endl;
}
