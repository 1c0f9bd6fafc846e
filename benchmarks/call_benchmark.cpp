// Round trips of a sensor call beside their limits, as the tables of README.md:
//   call_benchmark [rounds [part of the titles of the tables wanted]]

#include <sys/utsname.h>

#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>

#include "benchmarks/limits.hpp"
#include "benchmarks/ours.hpp"
#include "benchmarks/own_directory.hpp"

namespace gecos::benchmarks {
namespace {

using media::Kind;

std::string processor() {
  std::ifstream about("/proc/cpuinfo");
  for (std::string line; std::getline(about, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(": ") + 2);
  }
  return "unknown processor";
}

/// The candidates: each program with its cores.
class On {
 public:
  explicit On(Cores cores) : cores_(cores) {}

  Candidate limit(const char* name, std::unique_ptr<Pair> (*start)(Cores)) const {
    return {name, [start, cores = cores_] { return start(cores); }};
  }
  Candidate spinning() const { return limit("raw spinning ring", raw_spinning_ring); }
  Candidate yielding() const { return limit("raw yielding ring", raw_yielding_ring); }
  Candidate socket() const { return limit("raw Unix socket", raw_unix_socket); }
  Candidate lcm() const { return limit("raw LCM", raw_lcm); }

  Candidate ours(const std::string& name, Kind kind,
                 std::unique_ptr<Pair> (*start)(Kind, Cores)) const {
    return {name + std::string(media::to_string(kind)),
            [start, kind, cores = cores_] { return start(kind, cores); }};
  }
  Candidate packets(Kind kind) const { return ours("packets over ", kind, benchmarks::packets); }
  Candidate call(Kind kind) const { return ours("**sensor call** over ", kind, sensor_call); }
  Candidate python(Kind kind) const {
    return ours("sensor call from Python over ", kind, sensor_call_from_python);
  }

 private:
  Cores cores_;
};

void run(int rounds, const std::string& wanted) {
  utsname system{};
  ::uname(&system);
  std::printf("%s, Linux %s, %u cores; medians of %d rounds.\n", processor().c_str(),
              system.release, core_count(), rounds);

  const OwnDirectory directory;
  pin_client();
  const On one(Cores::One);
  const On two(Cores::Two);
  const auto table = [&](const char* title, const std::vector<Candidate>& candidates) {
    if (std::string(title).find(wanted) == std::string::npos) return;
    print_table(title, paired_rounds(candidates, rounds));
  };
  if (core_count() >= 2) {
    table("shm, two cores", {two.spinning(), two.yielding(), two.socket(), two.packets(Kind::Shm),
                             two.call(Kind::Shm), two.python(Kind::Shm)});
  }
  table("shm, one core", {one.yielding(), one.socket(), one.packets(Kind::Shm), one.call(Kind::Shm),
                          one.python(Kind::Shm)});
  if (core_count() >= 2) {
    const BusyNeighbours busy;
    table("a busy loop on each of two cores", {two.socket(), two.lcm(), two.packets(Kind::Shm),
                                               two.call(Kind::Shm), two.call(Kind::Lcm)});
  }
  if (core_count() >= 2) {
    table("lcm, two cores", {two.lcm(), two.socket(), two.packets(Kind::Lcm), two.call(Kind::Lcm),
                             two.python(Kind::Lcm)});
  }
  table("lcm, one core", {one.lcm(), one.socket(), one.packets(Kind::Lcm), one.call(Kind::Lcm),
                          one.python(Kind::Lcm)});
}

}  // namespace
}  // namespace gecos::benchmarks

int main(int argc, char** argv) {
  try {
    if (argc == 4 && std::string(argv[1]) == "serve") {
      const auto kind = gecos::media::kind_from(argv[2]);
      return gecos::benchmarks::serve_sensor(kind.value(), std::stoi(argv[3]));
    }
    const int rounds = argc > 1 ? std::stoi(argv[1]) : 11;
    if (rounds < 1) throw std::invalid_argument("at least one round");
    gecos::benchmarks::run(rounds, argc > 2 ? argv[2] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "call_benchmark: %s\n", error.what());
    return 1;
  }
}
