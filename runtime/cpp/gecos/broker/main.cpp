// The program gecos-broker: the directory that leads from an object's name to the addresses of its
// server.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "gecos/base/thread.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/broker/others.hpp"
#include "gecos/gecos.hpp"

namespace {

constexpr const char* usage =
    "usage: gecos-broker [--name-hold=SECONDS] [inproc|shm|lcm]...\n"
    "Runs the broker of this host: the directory in which programs find objects by name.\n"
    "The arguments are the media over which programs can reach the broker; without arguments,\n"
    "all available media. A silent server of another host keeps its names for SECONDS (10).\n"
    "Prints one line when it is ready. Ends on SIGINT or SIGTERM.\n";

constexpr std::string_view name_hold = "--name-hold=";

/// Reads a duration in seconds.
std::optional<gecos::Duration> seconds_of(const char* text) {
  char* end = nullptr;
  const double seconds = std::strtod(text, &end);
  if (end == text || *end != '\0' || !(seconds >= 0 && seconds <= 1e6)) return std::nullopt;
  return std::chrono::duration_cast<gecos::Duration>(std::chrono::duration<double>(seconds));
}

/// Searches for other brokers on a separate thread. The destructor waits for the end of the search.
class Search {
 public:
  ~Search() { thread_.join(); }

 private:
  std::thread thread_ = gecos::start_thread("gecos-others", gecos::broker::warn_of_other_brokers);
};

}  // namespace

int main(int count, char** arguments) {
  std::vector<gecos::media::Kind> media;
  gecos::broker::BrokerOptions broker_options;
  for (int at = 1; at < count; ++at) {
    if (std::strcmp(arguments[at], "--help") == 0 || std::strcmp(arguments[at], "-h") == 0) {
      std::fputs(usage, stdout);
      return 0;
    }
    if (std::string_view(arguments[at]).starts_with(name_hold)) {
      const auto seconds = seconds_of(arguments[at] + name_hold.size());
      if (!seconds) {
        std::fprintf(stderr, "gecos-broker: '%s': write seconds from 0 to 1000000\n%s",
                     arguments[at], usage);
        return 2;
      }
      broker_options.name_hold = *seconds;
      continue;
    }
    const auto kind = gecos::media::kind_from(arguments[at]);
    if (!kind) {
      std::fprintf(stderr, "gecos-broker: '%s' is not a medium\n%s", arguments[at], usage);
      return 2;
    }
    media.push_back(*kind);
  }
  gecos::Lab lab;
  gecos::broker::Broker broker(broker_options);
  gecos::ServeOptions options;
  options.program = "gecos-broker";
  options.ready = "gecos-broker: ready";
  options.started = [] { return std::make_shared<Search>(); };
  try {
    return gecos::serve(lab, {broker.serving(std::move(media))}, options);
  } catch (const std::system_error& why) {
    std::fprintf(stderr, "gecos-broker: %s\n",
                 gecos::session::nothing_left("a broker", why).c_str());
    return 1;
  }
}
