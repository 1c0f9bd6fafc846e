#pragma once

#include <cstdint>

#include "gecos/base/running_core.hpp"

namespace gecos {

/// What a core counts, and which core: a fraction of the cost of a clock, and good for one question
/// alone. Nothing at first.
struct Moment {
  std::uint64_t count = 0;  ///< of the processor's time stamps; 0 where programs cannot read them
  std::int32_t core = unknown_core;

  static Moment now() {
#if defined(__x86_64__)
    return {__builtin_ia32_rdtsc(), running_core()};
#elif defined(__aarch64__)
    std::uint64_t count = 0;
    asm volatile("mrs %0, cntvct_el0" : "=r"(count));
    return {count, running_core()};
#else
    return {};
#endif
  }

  /// Certainly less than 5 ms have passed since `last`, also where the process was stopped or the
  /// machine suspended. The counters of two cores may differ, so only one core's are compared. A
  /// suspended machine thaws its programs long after the counter goes on, and a counter that began
  /// anew is far away.
  bool just_after(const Moment& last) const {
    constexpr std::uint64_t near = 100'000;  // 100 µs at 1 GHz, 4 ms at the 25 MHz of an ARM
    return count != 0 && core == last.core && count - last.count < near;
  }
};

}  // namespace gecos
