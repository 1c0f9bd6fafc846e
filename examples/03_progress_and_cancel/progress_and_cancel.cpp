// Watches a motion while it runs, and cancels it when a third is done.

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

  const robcl::Trajectory slowly{.tool_speed = 0.02};  // m/s: this motion takes 5 s
  const auto move = robot->move(goal, slowly);
  while (move.wait_for(200ms) == gecos::State::Running) {
    const auto feedback = move.feedback();  // what this operation reports: a MotionProgress
    if (!feedback) continue;                // the motion has not begun
    std::cout << move.progress().detail << ' ' << static_cast<int>(100 * feedback->fraction)
              << " %, " << feedback->remaining << " s left" << std::endl;
    if (feedback->fraction >= 1.0 / 3)
      move.cancel();  // a request: the arm brakes, then the move ends
  }
  std::cout << move.state() << '/' << move.progress().detail << std::endl;
}
