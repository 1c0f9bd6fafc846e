// Watches the tool of an arm, whenever the arm is there: start, end and kill `robcl-rx90` as you
// like. Ctrl-C ends this program.

#include <chrono>
#include <iostream>
#include <thread>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace std::chrono_literals;

namespace {

/// Reads until the server is lost.
void watch(const robcl::Manipulator& robot) {
  auto tool = robot.tool(gecos::stream);
  if (!tool) return;
  if (const auto first = tool->next(5s)) {
    std::cout << "found: the tool is at " << first->value << std::endl;
  }
  while (!tool->lost()) static_cast<void>(tool->next(1s));  // use each sample here
  std::cout << "lost" << std::endl;
}

}  // namespace

int main() {
  gecos::Lab lab;
  for (;;) {  // a proxy does not outlive the server that it was created for: create a new one
    const auto robot = lab.create<robcl::Manipulator>("RX90");
    if (robot) {
      watch(*robot);
    } else {
      std::cout << "not found: " << robot.error() << std::endl;
      std::this_thread::sleep_for(500ms);  // before the next try
    }
  }
}
