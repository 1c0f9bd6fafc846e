// The limits beside which our own numbers stand: what a ring, a socket and LCM do with nothing of ours
// around them. Measured in the same run, round by round, since absolute times move from machine to machine.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gecos::benchmarks {

/// One ping-pong: a call sends a packet of 64 bytes and waits for the answer of another process.
class PingPong {
 public:
  virtual ~PingPong() = default;  ///< ends the other process
  virtual void call() = 0;
};

struct Candidate {
  std::string name;
  std::function<std::unique_ptr<PingPong>()> start;
};

/// Where the two processes run.
enum class Cores { Two, One };

/// Ring in shared memory, spinning without ever giving the core away. Hopeless on one core.
std::unique_ptr<PingPong> raw_spinning_ring(Cores cores);
/// The same, giving the core away after every look.
std::unique_ptr<PingPong> raw_yielding_ring(Cores cores);
/// A Unix stream socket, blocking.
std::unique_ptr<PingPong> raw_unix_socket(Cores cores);
/// LCM with a handler on each side, blocking in lcm_handle.
std::unique_ptr<PingPong> raw_lcm(Cores cores);

/// Pins this process. The server side of a pair goes to the other core when there are two.
void pin_client();
void pin_server(Cores cores);

/// A process that answers calls until its pair goes.
class Answering {
 public:
  explicit Answering(Cores cores, const std::function<void()>& serve);
  ~Answering();
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;

 private:
  int pid_;
};

/// Keeps every core busy with a program that never sleeps, as long as it lives.
class BusyNeighbours {
 public:
  BusyNeighbours();

 private:
  std::vector<std::unique_ptr<Answering>> loops_;
};

struct Result {
  std::string name;
  double p50_us = 0;
  double p99_us = 0;
  double ratio = 0;  ///< median over the rounds of p50 / p50 of the first candidate in that round
};

/// Runs all candidates in turn, `rounds` times, `calls` calls each; the first is the limit.
std::vector<Result> paired_rounds(const std::vector<Candidate>& candidates, int rounds, int calls);
/// A table in Markdown.
void print_table(const std::string& title, const std::vector<Result>& results);

}  // namespace gecos::benchmarks
