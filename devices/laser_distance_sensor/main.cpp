// robcl-lds: a simulated laser distance sensor that looks into the simulated world.
#include <chrono>
#include <cstdio>

#include "laser_distance_sensor/lds_servant.hpp"
#include "support/command_line.hpp"
#include "support/device_main.hpp"

namespace {

using namespace std::chrono_literals;

int run(int count, char** words) {
  const devices::CommandLine line(
      "robcl-lds",
      "Serves a simulated laser distance sensor. Where it stands at first, it looks across the "
      "table at\n"
      "the height to which the block is lifted.",
      {{"name", "LDS", "name to register"},
       {"world", "WORLD", "the world that it looks into"},
       {"carrier", "", "arm whose flange carries it; '' to stand in the world"},
       {"x", "1000", "of its base on the carrier, mm"},
       {"y", "200", "mm"},
       {"z", "250", "mm"},
       {"a", "0", "EulerZYZ of its base; it looks along z, deg"},
       {"b", "-90", "deg"},
       {"c", "0", "deg"},
       {"lower", "50", "of its range, mm"},
       {"upper", "1000", "of its range, mm"},
       {"seed", "1", "of its noise"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  devices::SimulatedBeam::Settings settings;
  settings.lower = robcl::mm(line.number("lower"));
  settings.upper = robcl::mm(line.number("upper"));
  settings.seed = static_cast<unsigned>(line.number("seed"));
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
                                .blocking = true,  // handlers ask the world
                                .beats = {{20ms, [&servant](double) { servant.publish(); }}}});
}

}  // namespace

int main(int count, char** words) {
  return devices::device_main("robcl-lds", [&] { return run(count, words); });
}
