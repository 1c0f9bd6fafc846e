#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "gecos/base/clock.hpp"
#include "gecos/base/thread.hpp"
#include "gil.hpp"

/// Functions that wait without the GIL. They wait in slices of time, and Python's signal handlers
/// run after each slice.
namespace gecos::python {

inline constexpr Duration longest_deafness = std::chrono::milliseconds(100);

/// Converts a time in seconds from Python. None and infinity mean that the wait has no limit.
/// Negative values mean zero. Raises ValueError for NaN.
inline Duration patience_of(std::optional<double> seconds) {
  if (seconds && std::isnan(*seconds)) {
    throw nanobind::value_error(
        "nan is no time to wait; give a number of seconds, or None to wait without limit");
  }
  if (!seconds || *seconds > 1e9) return Duration::max();
  if (!(*seconds > 0)) return Duration::zero();
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*seconds));
}

/// Calls `wait(until)` repeatedly without the GIL, each time for one slice of time. Ends when
/// `wait` returns true, when the time `seconds` has passed, or when `given_up` returns true;
/// `given_up` is called with the GIL. Python's signal handlers run between two slices. If they
/// raise an exception, such as KeyboardInterrupt, the exception ends the wait. Returns whether
/// `wait` returned true.
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

/// Runs `work` on a separate thread and waits for its result. `work` may block and must not use
/// Python. A signal can end the wait; `work` then continues, and its result is dropped.
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

/// Runs `work` without the GIL. `work` may block only for a short time.
template <class Work>
decltype(auto) without_gil(Work work) {
  const WithoutGil released;
  return work();
}

}  // namespace gecos::python
