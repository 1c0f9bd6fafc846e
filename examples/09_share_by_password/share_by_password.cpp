// Two of these at two terminals move one robot together: each `up` or `down` that is typed moves
// it by 20 mm. The first one sets the password, the next one joins by it:
// `share_by_password "two hands"`.

#include <iostream>
#include <string>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace robcl::literals;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main(int argc, char** argv) {
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  const auto lease = gecos::actor(*robot, argc > 1 ? argv[1] : "");
  if (!lease) return fail(lease.error());  // with another password: says who holds the robot
  const auto holders = gecos::holders(*robot).get();
  if (!holders) return fail(holders.error());
  std::cout << "programs that may move RX90: " << holders->size() << std::endl;

  for (std::string line; std::getline(std::cin, line);) {
    const auto here = robot->tool().get();
    if (!here) return fail(here.error());
    const double dz = line == "up" ? 20_mm : -20_mm;
    const auto moved = robot->move(robcl::translate(0, 0, dz) * *here).get();
    if (!moved) return fail(moved.error());
    std::cout << line << ": done" << std::endl;
  }
}
