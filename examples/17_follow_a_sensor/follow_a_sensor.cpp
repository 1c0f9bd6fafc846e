// Guides the tool by corrections, as a sensor would: 500 steps of 0.1 mm down, one per ms.

#include <chrono>
#include <cstdio>
#include <iostream>
#include <thread>

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
  auto alter = robot->alter(gecos::writer);
  if (!alter) return fail(alter.error());

  const auto before = robot->tool().get();
  if (!before) return fail(before.error());

  const auto follow =
      robot->follow(robcl::FollowMode::IN_TOOL, robcl::FollowLimits{.distance = 0.1});
  alter->feeds(follow);
  while (!follow.feedback() && follow.wait_for(1ms) == gecos::State::Running) {
  }  // with the first feedback the arm takes corrections
  auto next = std::chrono::steady_clock::now();
  for (int i = 0; i < 500; ++i) {
    const auto sent = alter->send(robcl::translate(0, 0, 0.1_mm));  // along the tool's z, down
    if (!sent) return fail(sent.error());
    std::this_thread::sleep_until(next += 1ms);
  }

  // Without corrections the arm stands at once, and the command ends by itself.
  const auto ended = follow.get();
  const auto stopped = ended ? std::nullopt : ended.error().as<robcl::CorrectionsStopped>();
  if (!stopped) return ended ? 0 : fail(ended.error());
  std::cout << stopped->state.applied << " corrections, " << stopped->state.dropped << " dropped\n";
  const auto after = robot->tool().get();
  if (!after) return fail(after.error());
  std::printf("moved by %.1f mm\n", robcl::in_mm(distance(*before, *after)));
}
