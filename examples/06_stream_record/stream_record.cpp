// Records 250 samples of the tool in a file, each of them once: `stream_record FILE`. That is one
// second: move the arm meanwhile, by another example.

#include <chrono>
#include <cstdint>
#include <fstream>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

using namespace std::chrono_literals;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 2) return fail("usage: stream_record FILE");
  gecos::Lab lab;
  auto robot = lab.create<robcl::Manipulator>("RX90");
  if (!robot) return fail(robot.error());
  auto tool = robot->tool(gecos::stream);  // reading needs no status
  if (!tool) return fail(tool.error());

  std::ofstream file(argv[1]);
  file << "sequence,lost,stamp,x,y,z\n" << std::fixed;
  std::uint64_t lost = 0;
  for (int i = 0; i < 250; ++i) {
    const auto sample = tool->next(5s);  // the next unread one; waits for it
    if (!sample) return fail(to_string(sample.error()));
    const robcl::Frame& at = sample->value;
    file << sample->sequence << ',' << sample->lost << ',' << sample->stamp << ',' << at.x() << ','
         << at.y() << ',' << at.z() << '\n';
    lost += sample->lost;  // number of samples that a slow reader lost
  }
  if (!file.flush()) return fail("the file could not be written");
  std::cout << "250 samples, " << lost << " lost" << std::endl;
}
