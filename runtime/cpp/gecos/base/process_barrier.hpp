#pragma once

/// Memory barriers that one process executes for several processes, by membarrier(2).
///
/// A thread of one process stores x and then loads y, and a thread of another process stores y and
/// then loads x. At least one of the two loads must see the other thread's store. Usually both
/// threads execute a full memory barrier between their store and their load. If one of the threads
/// does this seldom, and both processes have joined the barriers, that thread executes
/// `barrier_for_all` instead; the other thread then needs no barrier at run time, only one for the
/// compiler (std::atomic_signal_fence).
namespace gecos {

/// Joins this process to the barriers: from now on `barrier_for_all`, called in any process of this
/// host, also orders the memory accesses of the threads of this process. Returns false when the
/// kernel does not allow it: Linux before 4.16, or a seccomp filter. In a process with several
/// threads the first call waits for a grace period of the kernel, for example 10 ms. Each later
/// call takes less than 1 µs. A forked child should call the function again.
bool join_barriers() noexcept;

/// Executes a full memory barrier on every running thread of every process of this host that has
/// joined. Takes less than 1 µs while no thread of such a process runs on another core, and some µs
/// otherwise. Returns false, without a barrier, when the kernel does not allow it, for example
/// because this process has restricted its system calls.
[[nodiscard]] bool barrier_for_all() noexcept;

}  // namespace gecos
