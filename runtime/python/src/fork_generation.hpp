#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>

namespace gecos::python {

inline std::atomic<std::uint64_t> fork_counter{0};  // orders no other memory: relaxed

/// Number of forks between this process and the one that loaded the module. Used instead of the
/// process id, because `getpid` would take more than half as long as a whole call.
inline std::uint64_t fork_generation() { return fork_counter.load(std::memory_order_relaxed); }

/// Must be called once, before the first `fork_generation`.
inline void count_forks() {
  ::pthread_atfork(nullptr, nullptr, [] { fork_counter.fetch_add(1, std::memory_order_relaxed); });
}

}  // namespace gecos::python
