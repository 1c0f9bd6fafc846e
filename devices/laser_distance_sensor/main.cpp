// robcl-lds: a simulated laser distance sensor that looks into the simulated world.
#include <chrono>
#include <cstdio>

#include "command_line/command_line.hpp"
#include "gecos/gecos.hpp"
#include "laser_distance_sensor/lds_servant.hpp"
#include "periodic/periodic.hpp"

namespace {

using namespace std::chrono_literals;

}  // namespace

int main(int count, char** words) {
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
  gecos::Server server(lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  options.blocking = true;  // handlers ask the world
  if (const auto served = server.add(line.text("name"), servant, options); !served) {
    std::fprintf(stderr, "robcl-lds: %s\n", served.error().text.c_str());
    return 1;
  }
  const devices::Periodic publishing(20ms, [&servant](double) { servant.publish(); });
  std::printf("robcl-lds: %s is ready\n", line.text("name").c_str());
  std::fflush(stdout);
  server.run();
  return 0;
}
