// The paper polls like this: each turn of the loop would issue a new motion. It must not compile,
// and the compiler's message must name what to look at.
#include "robcl/manipulator_client.hpp"

void wait_for(const robcl::Manipulator& robot, const robcl::Frame& goal) {
#ifdef KEEP_THE_COMMAND
  const auto move = robot.move(goal);
  while (move.state() == gecos::State::Running) {
  }
#else
  while (robot.move(goal).state() == gecos::State::Running) {
  }
#endif
}
