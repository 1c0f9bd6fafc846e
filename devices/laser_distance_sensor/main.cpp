// The program robcl-lds: serves a simulated laser distance sensor, which measures distances in the
// simulated world.
#include <chrono>
#include <cstdio>

#include "devices/laser_distance_sensor/lds_servant.hpp"
#include "devices/support/command_line.hpp"
#include "devices/support/device_main.hpp"

namespace {

using namespace std::chrono_literals;

int run(int count, char** words) {
  const devices::CommandLine line(
      "robcl-lds",
      "Serves a simulated laser distance sensor. By default its beam crosses the table at the\n"
      "height to which the block is lifted.",
      {{"name", "LDS", "name under which clients find the sensor"},
       {"world", "WORLD", "name of the simulated world that has the bodies"},
       {"carrier", "", "arm whose flange carries the sensor; '' for none"},
       {"x", "1000", "x of the sensor's base, seen from its carrier, mm"},
       {"y", "200", "y of the sensor's base, mm"},
       {"z", "250", "z of the sensor's base, mm"},
       {"a", "0", "ZYZ Euler angles a, b, c of the base (beam along z), deg"},
       {"b", "-90", "second Euler angle b, deg"},
       {"c", "0", "third Euler angle c, deg"},
       {"lower", "50", "smallest distance that the sensor can measure, mm"},
       {"upper", "1000", "greatest distance that the sensor can measure, mm"},
       {"seed", "1", "seed of the simulated noise"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  devices::SimulatedBeam::Settings settings;
  settings.lower = robcl::mm(line.number("lower"));
  settings.upper = robcl::mm(line.number("upper"));
  settings.seed = static_cast<unsigned>(static_cast<long>(line.number("seed")));
  if (settings.lower < 0 || settings.upper <= settings.lower) {
    std::fputs("robcl-lds: --lower must be at least 0 and below --upper\n", stderr);
    return 2;
  }
  const auto position = [&line](const char* word) { return robcl::mm(line.number(word)); };
  const auto turn = [&line](const char* word) { return robcl::deg(line.number(word)); };
  gecos::Lab lab;
  devices::LdsServant servant(
      lab, line.text("world"), line.text("carrier"),
      robcl::Frame::from_euler_zyz(position("x"), position("y"), position("z"), turn("a"),
                                   turn("b"), turn("c")),
      settings);
  return devices::serve_device(lab, servant,
                               {.program = "robcl-lds",
                                .name = line.text("name"),
                                .clock = line.clock(),
                                .admission = line.admission(),
                                .blocking = true,  // handlers wait for answers of the world server
                                .beats = {{20ms, [&servant] { servant.publish(); }}}});
}

}  // namespace

int main(int count, char** words) {
  return devices::device_main("robcl-lds", [&] { return run(count, words); });
}
