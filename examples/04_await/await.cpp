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

Sequence lift(const robcl::Manipulator& robot) {
  const auto here = co_await robot.tool();
  if (!here) co_return false;
  const robcl::Trajectory slowly{.tool_speed = 0.02};  // m/s
  const auto lifted = co_await robot.move(robcl::translate(0, 0, 60_mm) * *here, slowly);
  std::cout << "arm: " << (lifted ? "lifted" : lifted.error().text) << std::endl;
  co_return lifted.has_value();
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

  auto lifting = lift(*robot);
  auto exercising = exercise(*gripper);
  const bool exercised = exercising.succeeded.get();
  return lifting.succeeded.get() && exercised ? 0 : 1;
}
