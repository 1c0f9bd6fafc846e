// Moves the tool along a square of 100 mm: first it stands at each corner, then it rounds them.

#include <chrono>
#include <cstdio>
#include <iostream>
#include <vector>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;
using robcl::translate;
using Moves = std::vector<gecos::Command<void, robcl::MotionProgress>>;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

/// Asks for all moves at once: the arm looks ahead.
Moves along_square(robcl::Manipulator& robot, const robcl::Frame& start, robcl::Blend at_corners) {
  const auto move = [&](const robcl::Frame& goal, robcl::Blend at_goal) {
    return robot.move(
        goal, robcl::Trajectory{
                  .path = robcl::PathType::STRAIGHT, .at_goal = at_goal, .tool_speed = 0.25});
  };
  Moves moves;
  moves.push_back(move(start * translate(0, 100_mm, 0), at_corners));
  moves.push_back(move(start * translate(0, 100_mm, -100_mm), at_corners));
  moves.push_back(move(start * translate(0, 0, -100_mm), at_corners));
  moves.push_back(move(start, robcl::Blend::BREAK));
  return moves;
}

int main() {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  const auto lease = gecos::actor(*robot);
  if (!lease) return fail(lease.error());
  const auto start = robot->tool().get();
  if (!start) return fail(start.error());

  for (const robcl::Blend at_corners : {robcl::Blend::BREAK, robcl::Blend::NOBREAK}) {
    const auto begun = std::chrono::steady_clock::now();
    const Moves moves = along_square(*robot, *start, at_corners);
    for (const auto& move : moves) {
      if (const auto moved = move.get(); !moved) return fail(moved.error());
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    std::printf("%s: %.1f s, corners passed by mm: [", to_string(at_corners).data(), took.count());
    const char* between = "";
    for (const auto& move : moves) {
      const auto feedback = move.feedback();
      if (!feedback || !feedback->corner) continue;
      std::printf("%s'%.1f'", std::exchange(between, ", "), robcl::in_mm(*feedback->corner));
    }
    std::printf("]\n");
  }
}
