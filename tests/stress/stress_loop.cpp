// A control loop at 1 kHz that is closed by a client in another process, and beside it a bare loop
// that only waits; tests/stress/control_loop.py starts all three and judges. The word says which:
//   device   serves LOOP, publishes a tick in each cycle, and expects its answer in the next
//   client   answers each tick, until the device is gone
//   bare     only waits for each cycle
// Each line of the input of a loop is a number of cycles. The loop runs that many, 1,000 a second,
// and then prints "from <ns> to <ns>", when the first and the last of them were due, "cycles <n>
// missed <n>", "woke <n> …" and "answered <n> …". The last two count by how late the loop woke, and
// how late the client had read the tick: in the place p, those that were less than 2^p us late and
// belong to no earlier place.
// A cycle is missed if the loop wakes only after the next one was due, and if the answer of its
// tick has not come when the next one begins.

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>
#include <system_error>

#include "devices/support/real_time.hpp"
#include "gecos/gecos.hpp"
#include "stress/loop_client.hpp"
#include "stress/loop_server.hpp"

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;  // CLOCK_MONOTONIC

constexpr auto period = 1ms;

/// Counts delays by powers of two of microseconds; the last place has all that are longer.
class Histogram {
 public:
  void add(Clock::duration delay) {
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(delay).count();
    const auto place =
        static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(std::max(us, 0L))));
    ++counts_[std::min(place, counts_.size() - 1)];
  }
  void print(const char* what) const {
    std::printf("%s", what);
    for (const int count : counts_) std::printf(" %d", count);
    std::printf("\n");
  }

 private:
  std::array<int, 16> counts_{};
};

void sleep_until(Clock::time_point when) {
  const auto since = when.time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since);
  const timespec at{static_cast<time_t>(seconds.count()),
                    static_cast<long>(std::chrono::nanoseconds(since - seconds).count())};
  int error = EINTR;
  while (error == EINTR) error = ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
  if (error != 0) throw std::system_error(error, std::generic_category(), "clock_nanosleep");
}

/// When each cycle is due. A cycle that was due before the previous one had begun is passed over.
class CycleTimer {
 public:
  CycleTimer() { sleep_until(due_); }
  /// Waits for the next cycle. Returns how many were passed over.
  std::int64_t wait() {
    sleep_until(due_ += period);
    const auto late = Clock::now() - due_;
    woke_.add(late);
    const auto passed = late / period;
    due_ += passed * period;
    return passed;
  }
  Clock::time_point first() const { return first_; }
  Clock::time_point due() const { return due_; }
  const Histogram& woke() const { return woke_; }

 private:
  // A whole millisecond of the clock: cycles of all processes are due at the same instants.
  const Clock::time_point first_ = std::chrono::ceil<std::chrono::milliseconds>(Clock::now());
  Clock::time_point due_ = first_;
  Histogram woke_;
};

std::int64_t in_ns(Clock::time_point when) {
  return std::chrono::nanoseconds(when.time_since_epoch()).count();
}

void print(std::int64_t cycles, std::int64_t missed, const CycleTimer& waits,
           const Histogram& answered) {
  std::printf("from %ld to %ld\n", in_ns(waits.first()), in_ns(waits.due()));
  std::printf("cycles %ld missed %ld\n", cycles, missed);
  waits.woke().print("woke");
  answered.print("answered");
  std::fflush(stdout);
}

class Device final : public stress::LoopServant {
 public:
  void run_closed(std::int64_t count) {
    CycleTimer waits;
    Histogram answered;
    std::int64_t missed = 0;
    std::int64_t cycle = 0;
    while (cycle < count) {
      due_ = in_ns(waits.due());
      publish_tick({.number = ++number_, .due = due_});
      const auto passed = waits.wait();
      missed += passed + (take_answer(answered) ? 0 : 1);
      cycle += 1 + passed;
    }
    print(cycle, missed, waits, answered);
  }

  gecos::Result<stress::Tick> tick() override {
    return stress::Tick{.number = number_, .due = due_};
  }
  gecos::Result<void> may_answer() override { return {}; }

 private:
  /// Whether the answer to the last tick is there.
  bool take_answer(Histogram& answered) {
    const auto last = answer().newest();
    if (!last || last->value.number != number_) return false;
    answered.add(std::chrono::nanoseconds(last->value.read - due_));
    return true;
  }

  // Of the last tick.
  std::atomic<std::int64_t> number_ = 0;
  std::atomic<std::int64_t> due_ = 0;
};

void run_bare(std::int64_t count) {
  CycleTimer waits;
  std::int64_t missed = 0;
  std::int64_t cycle = 0;
  while (cycle < count) {
    const auto passed = waits.wait();
    missed += passed;
    cycle += 1 + passed;
  }
  print(cycle, missed, waits, {});
}

template <class What>
int fail(const What& what) {
  std::cerr << what << std::endl;
  return 1;
}

/// Says whether the loop has a real-time priority; it runs without, too.
void take_priority() {
  const auto missing = devices::make_real_time();
  std::printf("priority: %s\n", missing ? missing->c_str() : "real-time");
}

/// Takes the real-time priority next below that of the bare loop, which therefore never waits for
/// the closed loop or its client. Takes none where the system permits none.
void take_priority_below_the_bare_loop() {
  take_priority();
  sched_param priority{};
  if (::sched_getparam(0, &priority) != 0) {
    throw std::system_error(errno, std::generic_category(), "sched_getparam");
  }
  if (priority.sched_priority == 0) return;
  --priority.sched_priority;
  if (::sched_setparam(0, &priority) != 0) {
    throw std::system_error(errno, std::generic_category(), "sched_setparam");
  }
}

/// Calls `run` with the number of cycles in each line of the input.
template <class Run>
int run_as_told(Run run) {
  std::puts("ready");
  std::fflush(stdout);
  for (std::int64_t cycles = 0; std::cin >> cycles;) {
    if (cycles <= 0) return fail("how many cycles?");
    run(cycles);
  }
  return std::cin.eof() ? 0 : fail("how many cycles?");
}

int serve() {
  gecos::Lab lab;
  Device device;
  gecos::Server server(lab);
  const auto added = server.add("LOOP", device, {.media = {gecos::media::Kind::Shm}});
  if (!added) return fail(added.error().text);
  take_priority_below_the_bare_loop();
  return run_as_told([&device](std::int64_t cycles) { device.run_closed(cycles); });
}

int run_bare_loop() {
  take_priority();
  return run_as_told(run_bare);
}

int answer() {
  gecos::Lab lab;
  auto loop = lab.create<stress::Loop>("LOOP", {.medium = gecos::media::Kind::Shm});
  if (!loop) return fail(loop.error());
  const auto lease = gecos::actor(*loop);
  if (!lease) return fail(lease.error());
  if (const auto may = loop->may_answer().get(); !may) return fail(may.error());
  auto ticks = loop->tick(gecos::stream);
  if (!ticks) return fail(ticks.error());
  auto answers = loop->answer(gecos::writer);
  if (!answers) return fail(answers.error());
  take_priority_below_the_bare_loop();
  std::puts("ready");
  std::fflush(stdout);
  for (;;) {
    const auto tick = ticks->next(60s);
    if (!tick) return 0;
    const auto sent = answers->send({.number = tick->value.number, .read = in_ns(Clock::now())});
    if (!sent) return fail(sent.error());
  }
}

}  // namespace

int main(int count, char** words) {
  const std::string role = count == 2 ? words[1] : "";
  if (role == "device") return serve();
  if (role == "client") return answer();
  if (role == "bare") return run_bare_loop();
  return fail("give device, client or bare");
}
