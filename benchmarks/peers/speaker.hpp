// What every program of `make bench-peers` says, so that one runner can drive all of them:
//   PROGRAM serve HOW           prints "ready ADDRESS" once it can be called, and serves until it
//   is killed
//   PROGRAM call HOW ADDRESS    prints "ready", then answers each line of standard input with a
//   line:
//     trips SECONDS                one call after the other      -> COUNT P50 P99 (ns)
//     unchecked SECONDS            the same with call_unchecked  -> COUNT P50 P99 (ns)
//     silent SECONDS COUNT         each after that long a rest   -> COUNT P50 P99 (ns)
//     outstanding NUMBER SECONDS   so many calls at a time       -> CALLS_PER_SECOND
//     late EACH SECONDS            each answered so late         -> COUNT
//     look SECONDS                 at the newest sample of a stream, again and again
//                                                                -> COUNT P50 P99 (ns)
//     follow SECONDS               the same, once in a millisecond
//                                                                -> COUNT
//     publish SECONDS              the server publishes samples, and measures
//                                                                -> COUNT P50 P99 (ns)
//   A program whose HOW begins with "images" sends and reads images, and answers the line
//   of images.hpp.
// What reading the clock takes is taken off P50 and P99. Needs nothing but the standard library,
// since the peers are built without ours.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace peers {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// The payload of every call and reply: 64 bytes.
struct Sample {
  double stamp = 0;
  std::array<double, 7> axis{};
};
static_assert(sizeof(Sample) == 64);

/// How long so many of something took, in ns.
struct Summary {
  std::size_t count = 0;
  double p50 = 0;
  double p99 = 0;
};

/// Does `once` again and again, and times it in bursts, since it may take less than reading the
/// clock does.
Summary time_bursts(Seconds how_long, const std::function<void()>& once);

/// A client that is connected. Throws when a call fails: a benchmark of failures is worth nothing.
class Client {
 public:
  virtual ~Client() = default;
  virtual Sample call(const Sample& sample) = 0;
  /// A call that needs no status and is not recorded; only ours has one.
  virtual Sample call_unchecked(const Sample& sample);
  /// A call that the server answers `late`; not every peer has one.
  virtual Sample call_late(const Sample& sample, Seconds late);
  /// Looks at the newest sample of a stream; not every peer has one.
  virtual void look();
  /// Has the server publish samples; not every peer has a stream.
  virtual Summary publish(Seconds how_long);
  /// Keeps `outstanding` calls on their way until `end`; how many were answered.
  virtual std::uint64_t calls_until(Clock::time_point end, unsigned outstanding) = 0;
};

/// A client that can issue a call without waiting for it, and take the answers in the order of the
/// calls.
class PipeliningClient : public Client {
 public:
  std::uint64_t calls_until(Clock::time_point end, unsigned outstanding) final;

 protected:
  virtual void issue(const Sample& sample) = 0;
  virtual Sample collect() = 0;
};

/// A speaker for peers whose calls block: as many threads as outstanding calls.
std::uint64_t calls_of_threads(Clock::time_point end, unsigned threads,
                               const std::function<void()>& call);

/// Says that the server can be called at `address`, which has no spaces and may be empty.
void say_ready(const std::string& address);

using Nanoseconds = std::chrono::duration<double, std::nano>;

Nanoseconds quantile(std::vector<Nanoseconds>& times, double part);

/// Returns what is between two looks at the clock when nothing else is.
Nanoseconds of_the_clock();

/// What answers one line of standard input, by a line of standard output.
using Answer = std::function<void(const std::string& line)>;

/// Speaks for `main`, with the answers that `connect` returns.
int speak_lines(
    int argc, char** argv, const std::function<void(const std::string& how)>& serve,
    const std::function<Answer(const std::string& how, const std::string& address)>& connect);

/// Speaks for `main` of calls. `serve` says that it is ready and does not return before the server
/// has ended.
int speak(int argc, char** argv, const std::function<void(const std::string& how)>& serve,
          const std::function<std::unique_ptr<Client>(const std::string& how,
                                                      const std::string& address)>& connect);

}  // namespace peers
