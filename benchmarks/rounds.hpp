// Round trips measured in turn, round by round, since absolute times move from machine to machine
// and from one second to the next: what is compared stands in the same round.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gecos::benchmarks {

using Microseconds = std::chrono::duration<double, std::micro>;

/// Where client and server of a pair run.
enum class Cores { Two, One };

unsigned core_count();
/// Pins this process, and what it starts from now on.
void pin_client();
void pin_server(Cores cores);

/// A client and, in another process, its server.
class Pair {
 public:
  virtual ~Pair() = default;  ///< ends the other process
  /// How long each round trip took, one after the other for `how_long`.
  virtual std::vector<Microseconds> round_trips(Microseconds how_long) = 0;
};

/// One whose client is this thread.
class PingPong : public Pair {
 public:
  /// Sends something small and waits for the answer.
  virtual void call() = 0;
  std::vector<Microseconds> round_trips(Microseconds how_long) final;
};

struct Candidate {
  std::string name;
  std::function<std::unique_ptr<Pair>()> start;
};

/// A process that runs `serve` until this is gone; then it is killed.
class OtherProcess {
 public:
  explicit OtherProcess(const std::function<void()>& serve);
  ~OtherProcess();
  OtherProcess(const OtherProcess&) = delete;
  OtherProcess& operator=(const OtherProcess&) = delete;

 private:
  int pid_;
};

/// Keeps both cores busy with a program that never sleeps, as long as it lives.
class BusyNeighbours {
 public:
  BusyNeighbours();

 private:
  std::vector<std::unique_ptr<OtherProcess>> loops_;
};

/// The figures of one candidate over all rounds.
struct Medians {
  std::string name;
  Microseconds p50{};
  Microseconds p99{};
  double ratio = 0;  ///< p50 / p50 of the first candidate in the same round
  double lowest_ratio = 0;
  double highest_ratio = 0;
};

/// Runs all candidates in turn, `rounds` times; the first is the limit. What reading the clock
/// takes is taken off.
std::vector<Medians> paired_rounds(const std::vector<Candidate>& candidates, int rounds);
/// A table in Markdown.
void print_table(const std::string& title, const std::vector<Medians>& results);

}  // namespace gecos::benchmarks
