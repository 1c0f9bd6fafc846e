// Watches the distance sensor on the flange of a robot that another program moves. When something
// is closer than 200 mm, takes over, retreats by 100 mm, and gives the robot back.
//
// To mount the sensor there:
//
//   gecos call LDS mount '{"carrier": "RX90", "offset": {"orientation": {"w": 1}}}'

#include <chrono>
#include <cmath>
#include <iostream>
#include <string>

#include "gecos/gecos.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/laser_distance_sensor_client.hpp"
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
  auto laser = lab.create<robcl::LaserDistanceSensor>("LDS");
  if (!laser) return fail(laser.error());
  const auto lease = gecos::actor(*robot, argc > 1 ? argv[1] : "");
  if (!lease) return fail(lease.error());
  auto beam = laser->beam(gecos::stream);
  if (!beam) return fail(beam.error());

  std::cout << "watching the distance" << std::endl;
  robcl::Distance seen;
  do {
    const auto sample = beam->next(std::chrono::seconds(10));
    if (!sample) return fail(sample.error());
    seen = sample->value;
  } while (!seen.valid || seen.value >= 200_mm);

  const auto taken = gecos::take_over(*robot).get();  // the other program's motion ends
  if (!taken) return fail(taken.error());
  std::cout << "taken over at " << std::lround(robcl::in_mm(seen.value)) << " mm" << std::endl;
  const auto here = robot->tool().get();
  if (!here) return fail(here.error());
  const auto moved = robot->move(robcl::translate(0, 0, 100_mm) * *here).get();
  if (!moved) return fail(moved.error());
  std::string looked;
  std::getline(std::cin, looked);  // until someone has looked, and presses Return
  const auto given_back = gecos::give_back(*robot).get();
  if (!given_back) return fail(given_back.error());
  const auto now = laser->measure().get();
  if (!now) return fail(now.error());
  std::cout << "given back at " << std::lround(robcl::in_mm(now->value)) << " mm" << std::endl;
}
