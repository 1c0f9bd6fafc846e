// Loaded before libc (LD_PRELOAD): each look at the wall clock finds it hours away from the last,
// forwards or back. Who waits until a time of the wall clock would wait for hours, so he is ended
// and named.

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/time.h>
#include <time.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace {

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// From 1970 to 2036, anywhere.
time_t jump() {
  static std::atomic<std::uint64_t> looks{1};
  std::uint64_t mixed = looks.fetch_add(1) * 0x9e3779b97f4a7c15u;
  mixed ^= mixed >> 29;
  return static_cast<time_t>(mixed % 2'100'000'000u);
}

[[noreturn]] void waits_by_the_wall_clock(const char* how) {
  std::fprintf(stderr, "wild clock: %s waits by the wall clock\n", how);
  std::abort();
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t which, timespec* now) noexcept {
  static auto* const real = next<int(clockid_t, timespec*)>("clock_gettime");
  const int failed = real(which, now);
  if (which == CLOCK_REALTIME || which == CLOCK_REALTIME_COARSE) now->tv_sec = jump();
  return failed;
}

int gettimeofday(timeval* now, void*) noexcept {
  now->tv_sec = jump();
  now->tv_usec = 0;
  return 0;
}

time_t time(time_t* into) noexcept {
  const time_t now = jump();
  if (into != nullptr) *into = now;
  return now;
}

int pthread_mutex_timedlock(pthread_mutex_t*, const timespec*) noexcept {
  waits_by_the_wall_clock("pthread_mutex_timedlock");
}

int sem_timedwait(sem_t*, const timespec*) { waits_by_the_wall_clock("sem_timedwait"); }

int pthread_cond_timedwait(pthread_cond_t*, pthread_mutex_t*, const timespec*) {
  waits_by_the_wall_clock("pthread_cond_timedwait");
}
}
