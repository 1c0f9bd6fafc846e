// Holds RAIL, lets it ride, and goes on as the lines say that it reads: one answer for each, as of
// programs/ask_of_rail.py.

#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "gecos/gecos.hpp"
#include "lab/rail_sensor_client.hpp"

using namespace std::chrono_literals;

namespace {

/// In one write: the library writes warnings to the same pipe meanwhile.
void say(const std::string& line) {
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);
}

template <class Command>
std::string told(const Command& command) {
  const auto result = command.get();
  if (result) return "FINISHED/DONE";
  std::ostringstream text;
  text << result.error();
  return text.str();
}

std::string registration(const lab::RailSensor& rail) {
  const auto described = gecos::describe(rail).get();
  return described ? described->registration : described.error().text;
}

/// Takes the status anew. `lease`: the last one that was granted.
std::string hold(const lab::RailSensor& rail, std::optional<gecos::Lease>& lease) {
  auto asked = gecos::actor(rail);
  if (asked) {
    lease.emplace(std::move(*asked));
    return "granted";
  }
  std::ostringstream text;
  text << "refused: " << asked.error();
  return text.str();
}

}  // namespace

int main(int argc, char** argv) {
  const auto medium = argc == 2 ? gecos::media::kind_from(argv[1]) : std::nullopt;
  if (!medium) {
    std::fputs("usage: ask_of_rail MEDIUM\n", stderr);
    return 2;
  }
  gecos::Lab lab;
  auto rail = lab.create<lab::RailSensor>("RAIL", {.medium = medium});
  if (!rail) {
    std::cerr << rail.error() << '\n';
    return 1;
  }
  std::optional<gecos::Lease> lease;
  if (const std::string held = hold(*rail, lease); !lease) {
    std::cerr << held << '\n';
    return 1;
  }
  const auto ride = rail->travel(1.0);
  while (ride.wait_for(10ms) == gecos::State::Running && ride.progress().fraction == 0.0) {
  }
  say("rides");
  for (std::string line; std::getline(std::cin, line);) {
    if (line == "ride") say("ride " + told(ride));
    if (line == "move") say("move " + told(rail->travel(0.5)));
    if (line == "read") say("read " + told(rail->measure()));
    if (line == "stop") say("stop " + told(gecos::stop(*rail)));
    if (line == "name") say("name " + registration(*rail));
    if (line == "hold") say("hold " + hold(*rail, lease));
  }
}
