// Reads the laser distance sensor once. `client shm` or `client lcm` names the medium to use.

#include <cstdio>
#include <iostream>

#include "gecos/gecos.hpp"
#include "robcl/laser_distance_sensor_client.hpp"

int main(int argc, char** argv) {
  gecos::Lab lab;
  gecos::CreateOptions options;
  if (argc > 1) {
    options.medium = gecos::media::kind_from(argv[1]);
    if (!options.medium) {
      std::cerr << "'" << argv[1] << "' is no medium; write inproc, shm or lcm\n";
      return 2;
    }
  }
  auto laser = lab.create<robcl::LaserDistanceSensor>("LASER", options);
  if (!laser) {
    std::cerr << laser.error() << '\n';
    return 1;
  }
  auto command = laser->measure();  // on its way; this program could do something else now
  auto distance = command.get();    // wait for it
  if (!distance) {
    std::cerr << distance.error() << '\n';
    return 1;
  }
  if (!distance->valid) {
    std::puts("nothing within reach");
    return 0;
  }
  std::printf("%.3f m\n", distance->value);
}
