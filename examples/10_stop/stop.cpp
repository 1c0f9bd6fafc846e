// Stops a robot that another program moves. Stopping needs no status: `gecos stop RX90` at a
// terminal does the same.

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
  gecos::Lab mover_lab;
  auto robot = mover_lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  auto lease = gecos::actor(*robot);
  if (!lease) return fail(lease.error());
  const auto at_start = robot->move(start).get();
  if (!at_start) return fail(at_start.error());
  const robcl::Trajectory slowly{.tool_speed = 0.02};  // m/s
  const auto move = robot->move(goal, slowly);
  while (move.progress().fraction < 0.1 && move.wait_for(50ms) == gecos::State::Running) {
  }

  gecos::Lab bystander_lab;  // a session of its own, as another program has; it holds no status
  auto same_robot = bystander_lab.create<robcl::Manipulator>("RX90");
  if (!same_robot) return fail(same_robot.error());
  if (const auto stopped = gecos::stop(*same_robot).get(); !stopped) return fail(stopped.error());

  tell("the move", move);
  tell("the next", robot->move(start));  // the stop has ended the lease, too
  lease = gecos::actor(*robot);          // acquire it again when the robot may move again
  if (!lease) return fail(lease.error());
  tell("with a new lease", robot->move(start));
}
