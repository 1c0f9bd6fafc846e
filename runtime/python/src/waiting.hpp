#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "gecos/base/clock.hpp"
#include "gecos/base/thread.hpp"
#include "gil.hpp"

/// Waiting without the GIL; Python's signal handlers run after each slice of time.
namespace gecos::python {

inline constexpr Duration longest_deafness = std::chrono::milliseconds(100);

/// Converts seconds from Python: None and infinity mean for ever, negative values and NaN zero.
inline Duration patience_of(std::optional<double> seconds) {
  if (!seconds || *seconds > 1e9) return Duration::max();
  if (!(*seconds > 0)) return Duration::zero();
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*seconds));
}

/// Calls `wait(until)` repeatedly, each time for a slice of time and without the GIL. Ends when
/// `wait` returns true, when the whole time has passed, or when `given_up`, which is called with
/// the GIL, returns true. Between two slices, Python's signal handlers run; an exception that they
/// raise (KeyboardInterrupt) ends the wait. Returns whether `wait` returned true.
template <class Wait, class GivenUp>
bool wait_in_slices(std::optional<double> seconds, Wait wait, GivenUp given_up) {
  const Duration patience = patience_of(seconds);
  const TimePoint begin = SystemClock().now();
  for (Duration passed{};;) {
    {
      const WithoutGil released;
      const auto slice = std::clamp(patience - passed, Duration::zero(), longest_deafness);
      if (wait(begin + passed + slice)) return true;
      passed = SystemClock().now() - begin;
    }
    if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
    if (passed >= patience || given_up()) return false;
  }
}

template <class Wait>
bool wait_in_slices(std::optional<double> seconds, Wait wait) {
  return wait_in_slices(seconds, std::move(wait), [] { return false; });
}

/// Waits until `until`, without the GIL.
inline void sleep_in_slices(TimePoint until) {
  const double left = std::chrono::duration<double>(until - SystemClock().now()).count();
  wait_in_slices(left, [](TimePoint slice) {
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(slice.time_since_epoch()));
    return false;
  });
}

/// Runs `work`, which blocks and must not touch Python, on a thread of its own, so that a signal
/// can end the wait. The work then continues, and its result is dropped.
template <class Work>
auto run_interruptibly(Work work) {
  using Value = decltype(work());
  const auto task = std::make_shared<std::packaged_task<Value()>>(std::move(work));
  std::future<Value> value = task->get_future();
  try {
    start_thread("gecos-python", [task] { (*task)(); }).detach();
  } catch (const std::system_error&) {  // no thread is available: a signal cannot end the wait
    const WithoutGil released;
    (*task)();
  }
  wait_in_slices(std::nullopt, [&](TimePoint until) {
    return value.wait_until(until) == std::future_status::ready;
  });
  return value.get();
}

/// Runs `work`, which may block for a short time, without the GIL.
template <class Work>
decltype(auto) without_gil(Work work) {
  const WithoutGil released;
  return work();
}

}  // namespace gecos::python
