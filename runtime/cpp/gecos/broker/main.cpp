// The program gecos-broker: the directory that leads from an object's name to the addresses of its
// server.
#include <cstdio>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "gecos/base/thread.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/broker/others.hpp"
#include "gecos/gecos.hpp"

namespace {

constexpr const char* usage =
    "usage: gecos-broker [inproc|shm|lcm]...\n"
    "Runs the broker of this host: the directory in which programs find objects by name.\n"
    "The arguments are the media over which programs can reach the broker; without arguments,\n"
    "all available media. Prints one line when it is ready. Ends on SIGINT or SIGTERM.\n";

/// The search for other brokers, on a thread of its own, until its end.
class Search {
 public:
  ~Search() { thread_.join(); }

 private:
  std::thread thread_ = gecos::start_thread("gecos-others", gecos::broker::warn_of_other_brokers);
};

}  // namespace

int main(int count, char** arguments) {
  std::vector<gecos::media::Kind> media;
  for (int at = 1; at < count; ++at) {
    if (std::strcmp(arguments[at], "--help") == 0 || std::strcmp(arguments[at], "-h") == 0) {
      std::fputs(usage, stdout);
      return 0;
    }
    const auto kind = gecos::media::kind_from(arguments[at]);
    if (!kind) {
      std::fprintf(stderr, "gecos-broker: '%s' is not a medium\n%s", arguments[at], usage);
      return 2;
    }
    media.push_back(*kind);
  }
  gecos::Lab lab;
  gecos::broker::Broker broker;
  gecos::ServeOptions options;
  options.program = "gecos-broker";
  options.ready = "gecos-broker: ready";
  options.started = [] { return std::make_shared<Search>(); };
  return gecos::serve(lab, {broker.serving(std::move(media))}, options);
}
