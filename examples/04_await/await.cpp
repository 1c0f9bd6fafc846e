// An arm and a gripper, each with a sequence of its own. `co_await` goes on when a command has
// ended, so neither sequence needs a thread.

#include <exception>
#include <future>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/gripper_client.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;

namespace {

// Tool frames in the world: z points down, so the second one is 60 mm below the first.
const robcl::Frame start =
    robcl::Frame::from_euler_zyz(500_mm, 200_mm, 250_mm, 0_deg, 180_deg, 0_deg);
const robcl::Frame goal = start * robcl::translate(0, 0, 60_mm);

/// A coroutine that starts at once and promises whether it came to its end. Any coroutine type
/// will do: this is a small one.
struct Sequence {
  struct promise_type {
    std::promise<bool> succeeded{};
    Sequence get_return_object() { return {succeeded.get_future()}; }
    std::suspend_never initial_suspend() noexcept { return {}; }
    std::suspend_never final_suspend() noexcept { return {}; }
    void return_value(bool value) { succeeded.set_value(value); }
    void unhandled_exception() { std::terminate(); }
  };
  std::future<bool> succeeded;
};

Sequence lower(const robcl::Manipulator& robot) {
  const auto at_start = co_await robot.move(start);
  if (!at_start) co_return false;
  std::cout << "arm: at its start" << std::endl;
  const auto lowered = co_await robot.move(goal, {{.tool_speed = 0.03}});  // m/s: 2 s
  if (!lowered) co_return false;
  std::cout << "arm: lowered" << std::endl;
  co_return true;
}

Sequence exercise(const robcl::Gripper& gripper) {
  for (const double width : {90_mm, 50_mm}) {
    const auto opened = co_await gripper.open(width);
    if (!opened) co_return false;
    std::cout << "gripper: " << robcl::in_mm(width) << " mm" << std::endl;
  }
  co_return true;
}

}  // namespace

int main() {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  auto gripper = lab.create<robcl::Gripper>("GRIPPER");
  const auto robot_lease = gecos::actor(*robot);  // where there is no robot, `*` ends the program
  const auto gripper_lease = gecos::actor(*gripper);  // with the text of the error
  if (!robot_lease || !gripper_lease) return 1;

  auto lowering = lower(*robot);
  auto exercising = exercise(*gripper);
  const bool exercised = exercising.succeeded.get();
  return lowering.succeeded.get() && exercised ? 0 : 1;
}
