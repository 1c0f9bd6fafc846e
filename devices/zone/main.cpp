// The program robcl-zone: serves a zone of the laboratory. Objects that the lab file places in the
// zone move only while a person is known to be present.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <sstream>
#include <vector>

#include "devices/support/command_line.hpp"
#include "devices/support/device_main.hpp"
#include "devices/zone/zone_servant.hpp"

namespace {

using namespace std::chrono_literals;

std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream in(list);
  for (std::string name; std::getline(in, name, ',');) {
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

int run(int count, char** words) {
  const devices::CommandLine line(
      "robcl-zone",
      "Serves a zone: a part of the laboratory in which a person must be present before a robot\n"
      "moves. Prints the codes for check-ins, so run it where only persons in the laboratory see\n"
      "its output. It is an interlock in software, not a safety function.",
      {{"name", "CELL", "name of the zone"},
       {"doors", "", "names of the door contacts that report, separated by commas"},
       {"buttons", "", "names of the dead-man buttons that report, separated by commas"},
       {"simulate", "", "doors and buttons that this program itself reports as closed and held"}},
      count, words);
  if (line.exit_status()) return *line.exit_status();

  const std::string name = line.text("name");
  const auto doors = names_in(line.text("doors")), buttons = names_in(line.text("buttons"));
  const auto simulated = names_in(line.text("simulate"));
  for (const std::string& source : simulated) {
    if (!contains(doors, source) && !contains(buttons, source)) {
      return devices::fail("robcl-zone", "--simulate: the zone has no door or button '" + source +
                                             "'; name it in --doors or --buttons, too");
    }
  }
  gecos::Lab lab;
  devices::ZoneServant servant(
      name, {.buttons = buttons, .doors = doors}, [&name](const std::string& code) {
        std::printf("robcl-zone: the code of %s is %s, for 60 s\n", name.c_str(), code.c_str());
        std::fflush(stdout);
      });
  return devices::serve_device(lab, servant,
                               {.program = "robcl-zone",
                                .name = name,
                                .simulated = !simulated.empty(),
                                .admission = line.admission(),
                                .beats = {{100ms, [&] {
                                             servant.simulate(simulated);
                                             servant.publish();
                                           }}}});
}

}  // namespace

int main(int count, char** words) {
  return devices::device_main("robcl-zone", [&] { return run(count, words); });
}
