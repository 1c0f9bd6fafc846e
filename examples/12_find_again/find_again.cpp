// Reads a sensor for ever, whenever its server is there: start, end and kill `robcl-lds` as you
// like. Ctrl-C ends it.

#include <chrono>
#include <iostream>
#include <thread>

#include "gecos/gecos.hpp"
#include "robcl/laser_distance_sensor_client.hpp"

using namespace std::chrono_literals;

namespace {

/// Reads until the server is lost.
void read_from(const robcl::LaserDistanceSensor& laser) {
  auto beam = laser.beam(gecos::stream);
  if (!beam) return;
  bool told = false;
  while (!beam->lost()) {
    const auto sample = beam->next(1s);
    if (!sample || told) continue;
    std::cout << "found: " << sample->value.value << " m" << std::endl;
    told = true;
  }
  std::cout << "lost" << std::endl;
}

}  // namespace

int main() {
  gecos::Lab lab;
  for (;;) {  // a proxy whose server is gone stays dead: create a new one
    const auto laser = lab.create<robcl::LaserDistanceSensor>("LDS");
    if (laser) {
      read_from(*laser);
    } else {
      std::cout << "not found: " << laser.error() << std::endl;
      std::this_thread::sleep_for(500ms);  // before the next try
    }
  }
}
