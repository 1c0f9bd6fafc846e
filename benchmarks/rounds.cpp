#include "benchmarks/rounds.hpp"

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace gecos::benchmarks {
namespace {

constexpr Microseconds measured_for = std::chrono::milliseconds(250);
constexpr Microseconds warmed_for = std::chrono::milliseconds(100);

/// The cores that this program was given.
const std::vector<int>& cores() {
  static const std::vector<int> given = [] {
    std::vector<int> cores;
    cpu_set_t set;
    CPU_ZERO(&set);
    ::sched_getaffinity(0, sizeof set, &set);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(core, &set)) cores.push_back(core);
    }
    return cores;
  }();
  return given;
}

void pin(std::size_t core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cores()[core % cores().size()], &set);
  ::sched_setaffinity(0, sizeof set, &set);
}

template <class T>
T at_quantile(std::vector<T>& values, double quantile) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(static_cast<double>(values.size() - 1) * quantile)];
}

class Nothing final : public PingPong {
 public:
  void call() override {}
};

struct Rounds {
  std::vector<Microseconds> p50s;
  std::vector<Microseconds> p99s;
  std::vector<double> ratios;
};

}  // namespace

unsigned core_count() { return static_cast<unsigned>(cores().size()); }
void pin_client() { pin(0); }
void pin_server(Cores where) { pin(where == Cores::Two ? 1 : 0); }

std::vector<Microseconds> PingPong::round_trips(Microseconds how_long) {
  using Clock = std::chrono::steady_clock;
  std::vector<Microseconds> times;
  times.reserve(1 << 22);
  auto before = Clock::now();
  const auto end = before + how_long;
  while (before < end) {
    call();
    const auto after = Clock::now();
    times.push_back(after - before);
    before = after;
  }
  return times;
}

OtherProcess::OtherProcess(const std::function<void()>& serve) : pid_(::fork()) {
  if (pid_ != 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    serve();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "the other process of the benchmark: %s\n", error.what());
  }
  ::_exit(1);
}

OtherProcess::~OtherProcess() {
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

BusyNeighbours::BusyNeighbours() {
  for (const Cores where : {Cores::One, Cores::Two}) {
    loops_.push_back(std::make_unique<OtherProcess>([where] {
      pin_server(where);
      std::atomic<unsigned> turns{0};
      for (;;) turns.fetch_add(1, std::memory_order_relaxed);
    }));
  }
}

std::vector<Medians> paired_rounds(const std::vector<Candidate>& candidates, int rounds) {
  auto of_clock = Nothing().round_trips(warmed_for);
  const Microseconds clock = at_quantile(of_clock, 0.5);
  std::vector<Rounds> measured(candidates.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const auto pair = candidates[i].start();
      pair->round_trips(warmed_for);
      auto times = pair->round_trips(measured_for);
      measured[i].p50s.push_back(at_quantile(times, 0.5) - clock);
      measured[i].p99s.push_back(at_quantile(times, 0.99) - clock);
      measured[i].ratios.push_back(measured[i].p50s.back() / measured[0].p50s.back());
    }
  }
  std::vector<Medians> results;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Rounds& of = measured[i];
    results.push_back({candidates[i].name, at_quantile(of.p50s, 0.5), at_quantile(of.p99s, 0.5),
                       at_quantile(of.ratios, 0.5), of.ratios.front(), of.ratios.back()});
  }
  return results;
}

void print_table(const std::string& title, const std::vector<Medians>& results) {
  std::printf("\n| %s | p50 µs | p99 µs | × %s | in the rounds |\n|---|--:|--:|--:|--:|\n",
              title.c_str(), results.front().name.c_str());
  for (const Medians& of : results) {
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f to %.2f |\n", of.name.c_str(), of.p50.count(),
                of.p99.count(), of.ratio, of.lowest_ratio, of.highest_ratio);
  }
  std::fflush(stdout);
}

}  // namespace gecos::benchmarks
