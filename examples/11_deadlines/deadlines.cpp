// Bounds how long a motion may take: by a deadline, which ends the motion, or by one's own
// patience, which leaves it running.

#include <chrono>
#include <iostream>
#include <string_view>

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

/// Waits for its end, and says how it ended.
template <class Command>
void tell(std::string_view what, const Command& command) {
  const auto result = command.get();
  std::cout << what << ": ";
  if (result) std::cout << command.state() << std::endl;
  if (!result) std::cout << result.error() << std::endl;
}

int main() {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  const auto lease = gecos::actor(*robot);
  if (!lease) return fail(lease.error());
  const auto at_start = robot->move(start).get();
  if (!at_start) return fail(at_start.error());
  const robcl::Trajectory slowly{.tool_speed = 0.03};  // m/s: 3.3 s

  tell("deadline of 0.5 s",
       gecos::with(*robot, {.deadline = 500ms}).move(goal, slowly));                  // it stands
  tell("deadline of 0 s", gecos::with(*robot, {.deadline = 0s}).move(goal, slowly));  // not sent

  const auto move = robot->move(goal, slowly);
  std::cout << "patience of 0.5 s: " << move.wait_for(500ms) << std::endl;  // the arm moves on
  tell("in the end", move);
}
