// Resets the drives of BENCH after a fault, and turns its first joint to 10 degrees.

#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/units.hpp"
#include "workshop/bench_arm_client.hpp"

int main() {
  gecos::Lab lab;
  auto arm = lab.create<workshop::BenchArm>("BENCH");
  if (!arm) {
    std::cerr << arm.error() << '\n';
    return 1;
  }
  const auto lease = gecos::actor(*arm);  // until the end of main no other program moves it
  if (!lease) {
    std::cerr << lease.error() << '\n';
    return 1;
  }
  if (auto reset = arm->reset_drives().get(); !reset) {
    std::cerr << reset.error() << '\n';
    return 1;
  }
  auto joints = arm->joints().get();
  if (!joints) {
    std::cerr << joints.error() << '\n';
    return 1;
  }
  joints->position[0] = robcl::deg(10);
  if (auto moved = arm->move_joints(*joints).get(); !moved) {
    std::cerr << moved.error() << '\n';
    return 1;
  }
  std::cout << "joint 1 is at 10 degrees\n";
}
