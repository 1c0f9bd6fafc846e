// The paper's program: a robot grips a block and lifts it by 200 mm.
//
// `grip_block [--leave] [MEDIUM]`; with --leave it ends without waiting for the lift, as the
// paper's does. The block is lifted all the same: status that is given back drains first.

#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/gripper_client.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;
using namespace std::chrono_literals;
using robcl::Frame;

namespace {

constexpr const char* usage =
    "usage: grip_block [--leave] [shm|lcm]\n"
    "Grips a block and lifts it by 200 mm. The medium is chosen by the host unless it is named.\n"
    "  --leave  end without waiting for the lift: the block is lifted all the same\n";

// Where the robot stands and where the block is gripped, in the world. The grip frame's z axis is
// the direction in which the tool approaches, so it points down.
const Frame robot_base;
const Frame block = Frame::from_euler_zyz(500_mm, 200_mm, 50_mm, 0_deg, 180_deg, 0_deg);
const Frame above_block = block * robcl::translate(0, 0, -200_mm);

/// Waits for a command and tells its states and how far it is.
template <class C>
bool follow(std::string_view what, const C& command) {
  std::optional<gecos::Detail> told;
  double told_fraction = 0;
  do {
    const gecos::Progress now = command.progress();
    if (now.detail != told || now.fraction >= told_fraction + 0.25) {
      std::cout << what << ": " << gecos::project(now.detail) << '/' << now.detail << ' '
                << static_cast<int>(100 * now.fraction) << " %" << std::endl;
      told = now.detail;
      told_fraction = now.fraction;
    }
  } while (command.wait_for(20ms) == gecos::State::Running);
  const auto result = command.get();
  if (result) {
    std::cout << what << ": " << gecos::State::Finished << std::endl;
    return true;
  }
  std::cerr << what << ": " << result.error() << std::endl;
  return false;
}

template <class Error>
int give_up(const Error& error) {
  std::cerr << error << std::endl;
  return 1;
}

int grip_and_lift(bool leave, gecos::CreateOptions options) {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>({"RX90", "SIM"}, options);
  if (!robot) return give_up(robot.error());
  auto gripper = lab.create<robcl::Gripper>("GRIPPER", options);
  if (!gripper) return give_up(gripper.error());

  auto robot_lease = gecos::actor(*robot);
  if (!robot_lease) return give_up(robot_lease.error());
  auto gripper_lease = gecos::actor(*gripper);
  if (!gripper_lease) return give_up(gripper_lease.error());

  if (!follow("mount", robot->mount("", robot_base))) return 1;

  // Approach and opening overlap: both are on their way before either is waited for.
  auto approach = robot->move(above_block);
  auto opening = gripper->open(100_mm);
  if (!follow("open", opening) || !follow("approach", approach)) return 1;

  const robcl::Trajectory slowly{.speed = 0.5, .path = robcl::PathType::STRAIGHT};
  if (!follow("go down", robot->move(block, slowly))) return 1;

  auto force = gripper->max_force().get();
  if (!force) return give_up(force.error());
  if (!follow("close", gripper->close(0.3 * *force))) return 1;

  auto lift = robot->move(above_block, slowly);
  if (leave) {
    std::cout << "lift: left to the robot" << std::endl;
    return 0;
  }
  return follow("lift", lift) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  bool leave = false;
  gecos::CreateOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--leave") {
      leave = true;
    } else if (word == "--help" || word == "-h") {
      std::cout << usage;
      return 0;
    } else if (options.medium = gecos::media::kind_from(word); !options.medium) {
      std::cerr << "grip_block: '" << word << "' is not known\n" << usage;
      return 2;
    }
  }
  return grip_and_lift(leave, options);
}
