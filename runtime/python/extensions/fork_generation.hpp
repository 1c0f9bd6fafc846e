#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>

namespace gecos::python {

inline std::atomic<std::uint64_t> fork_counter{0};  // orders no other data: relaxed access

/// Returns the number of forks between the process that loaded the module and this process. Code
/// uses this number and not the process id, because `getpid` would take more than half of the time
/// of a whole call.
inline std::uint64_t fork_generation() { return fork_counter.load(std::memory_order_relaxed); }

/// Starts the counting of forks. Must be called once, before the first call of `fork_generation`.
inline void count_forks() {
  ::pthread_atfork(nullptr, nullptr, [] { fork_counter.fetch_add(1, std::memory_order_relaxed); });
}

}  // namespace gecos::python
