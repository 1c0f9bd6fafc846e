// Loaded before a program by LD_PRELOAD: after as many threads as the environment variable
// THREADS_LEFT says, no further thread can be started. A limit of the kernel counts the threads of
// a whole user, and does not bind root.
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>

extern "C" [[gnu::visibility("default")]] int pthread_create(pthread_t* thread,
                                                             const pthread_attr_t* attributes,
                                                             void* (*run)(void*),
                                                             void* argument) noexcept {
  static const auto real =
      reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  static std::atomic<int> left = std::atoi(std::getenv("THREADS_LEFT"));  // shared by all threads
  return left.fetch_sub(1) > 0 ? real(thread, attributes, run, argument) : EAGAIN;
}
