#pragma once

#include <sched.h>

#include <cstddef>
#include <cstdint>

// Two declarations from <sys/rseq.h> of glibc 2.35. The symbols are weak, because an older glibc
// does not define them.
extern "C" {
extern const std::ptrdiff_t __rseq_offset [[gnu::weak]];
extern const unsigned int __rseq_size [[gnu::weak]];
}

namespace gecos {

/// The number that means that the CPU core is unknown.
inline constexpr std::int32_t unknown_core = -1;

/// Returns the number of the CPU core of the calling thread. The kernel stores this number in the
/// memory of the thread (restartable sequences), so that this function is one load. The result is
/// negative when the thread is not registered for restartable sequences.
inline std::int32_t registered_core() {
#if defined(__x86_64__) || defined(__aarch64__)
  constexpr std::ptrdiff_t cpu_id = 4;  // its offset in struct rseq, which is kernel ABI
  if (&__rseq_size == nullptr || &__rseq_offset == nullptr || __rseq_size == 0) return unknown_core;
#ifdef __x86_64__
  const char* thread = nullptr;
  asm("mov %%fs:0, %0" : "=r"(thread));
#else
  const char* const thread = static_cast<const char*>(__builtin_thread_pointer());
#endif
  return *reinterpret_cast<const volatile std::int32_t*>(thread + __rseq_offset + cpu_id);
#else
  return unknown_core;
#endif
}

/// Returns the number of the CPU core that the calling thread runs on. The kernel may move the
/// thread to another core right afterwards.
inline std::int32_t running_core() {
  const std::int32_t core = registered_core();
  return core >= 0 ? core : ::sched_getcpu();
}

}  // namespace gecos
