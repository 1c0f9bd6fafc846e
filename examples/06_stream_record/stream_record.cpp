// Records 50 samples of the distance sensor in a file, each of them once: `stream_record FILE`.

#include <chrono>
#include <cstdint>
#include <fstream>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/laser_distance_sensor_client.hpp"

using namespace std::chrono_literals;

template <class Error>
int fail(const Error& error) {
  std::cerr << error << '\n';
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 2) return fail("usage: stream_record FILE");
  gecos::Lab lab;
  auto laser = lab.create<robcl::LaserDistanceSensor>("LDS");
  if (!laser) return fail(laser.error());
  auto beam = laser->beam(gecos::stream);
  if (!beam) return fail(beam.error());

  std::ofstream file(argv[1]);
  file << "sequence,lost,stamp,valid,distance\n";
  std::uint64_t lost = 0;
  for (int i = 0; i < 50; ++i) {
    const auto sample = beam->next(5s);  // the next unread one; waits for it
    if (!sample) return fail(to_string(sample.error()));
    const robcl::Distance& distance = sample->value;
    file << sample->sequence << ',' << sample->lost << ',' << std::fixed << distance.stamp << ','
         << distance.valid << ',' << distance.value << '\n';
    lost += sample->lost;  // by a reader that is slower than the sensor for too long
  }
  if (!file.flush()) return fail("the file could not be written");
  std::cout << "50 samples, " << lost << " lost" << std::endl;
}
