#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>

namespace gecos::python {

namespace lineage {

inline std::atomic<std::uint64_t> generation{0};  // publishes nothing but itself

}  // namespace lineage

/// How many forks lie between this process and the one that loaded the module. Asking the kernel
/// which process this is takes longer than half a call does.
inline std::uint64_t forks() { return lineage::generation.load(std::memory_order_relaxed); }

/// Once, before `forks` is asked.
inline void count_forks() {
  ::pthread_atfork(nullptr, nullptr,
                   [] { lineage::generation.fetch_add(1, std::memory_order_relaxed); });
}

}  // namespace gecos::python
