#pragma once

#include <sched.h>

#include <cstddef>
#include <cstdint>

// Declarations of <sys/rseq.h> of glibc 2.35. Weak symbols: an older glibc has neither.
extern "C" {
extern const std::ptrdiff_t __rseq_offset [[gnu::weak]];
extern const unsigned int __rseq_size [[gnu::weak]];
}

namespace gecos {

/// The value for a core that is not known.
inline constexpr std::int32_t unknown_core = -1;

/// The core of the calling thread. The kernel stores it in the memory of the thread (restartable
/// sequences), so this is one load. Negative when the thread has not registered for restartable
/// sequences.
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

/// The core that the calling thread runs on; the kernel may move the thread right afterwards.
inline std::int32_t running_core() {
  const std::int32_t core = registered_core();
  return core >= 0 ? core : ::sched_getcpu();
}

}  // namespace gecos
