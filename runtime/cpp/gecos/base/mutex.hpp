#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "gecos/base/clock.hpp"
#include "gecos/base/thread_annotations.hpp"

namespace gecos {

/// A std::mutex that clang's thread-safety analysis knows: members can declare that a Mutex guards
/// them (thread_annotations.hpp).
class GECOS_CAPABILITY("mutex") Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void lock() GECOS_ACQUIRE() { mutex_.lock(); }
  bool try_lock() GECOS_TRY_ACQUIRE(true) { return mutex_.try_lock(); }
  void unlock() GECOS_RELEASE() { mutex_.unlock(); }
  /// Tells clang's thread-safety analysis that the calling thread holds this mutex. Checks nothing
  /// at run time.
  void assert_held() const GECOS_ASSERT_HELD() {}

 private:
  friend class ConditionVariable;
  std::mutex mutex_;
};

/// A mutex that every call or every published sample locks for a short time, and for which threads
/// hardly ever compete. Locking and unlocking cost two atomic operations and no function call,
/// which is less than half the time of std::mutex. A thread that must wait sleeps. The algorithm is
/// mutex2 of U. Drepper, "Futexes Are Tricky", 2011.
class GECOS_CAPABILITY("mutex") FutexMutex {
 public:
  FutexMutex() = default;
  FutexMutex(const FutexMutex&) = delete;
  FutexMutex& operator=(const FutexMutex&) = delete;

  void lock() GECOS_ACQUIRE() {
    if (!take()) wait();
  }
  bool try_lock() GECOS_TRY_ACQUIRE(true) { return take(); }
  void unlock() GECOS_RELEASE() {
    if (state_.exchange(free, std::memory_order_release) == contended) state_.notify_one();
  }
  /// Tells clang's thread-safety analysis that the calling thread holds this mutex. Checks nothing
  /// at run time.
  void assert_held() const GECOS_ASSERT_HELD() {}

 private:
  static constexpr std::uint32_t free = 0;
  static constexpr std::uint32_t held = 1;
  /// The state of a mutex that a thread holds while other threads may sleep until the mutex is
  /// free.
  static constexpr std::uint32_t contended = 2;

  bool take() {
    std::uint32_t expected = free;
    return state_.compare_exchange_strong(expected, held, std::memory_order_acquire,
                                          std::memory_order_relaxed);
  }
  void wait() {
    while (state_.exchange(contended, std::memory_order_acquire) != free) {
      state_.wait(contended, std::memory_order_relaxed);
    }
  }

  std::atomic<std::uint32_t> state_{free};  // acquire and release order the guarded data
};

/// Holds a mutex while this object lives, like std::unique_lock.
template <class M>
class GECOS_SCOPED_CAPABILITY MutexLock {
 public:
  explicit MutexLock(M& mutex) GECOS_ACQUIRE(mutex) : mutex_(mutex) { mutex_.lock(); }
  /// Takes over a mutex that the calling thread has already locked, for example by `try_lock()`.
  MutexLock(M& mutex, std::adopt_lock_t) GECOS_REQUIRES(mutex) : mutex_(mutex) {}
  ~MutexLock() GECOS_RELEASE() {
    if (holds_) mutex_.unlock();
  }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  /// Unlocks the mutex before this object is destroyed. @pre the mutex is held
  void unlock() GECOS_RELEASE() {
    mutex_.unlock();
    holds_ = false;
  }
  /// Locks the mutex again. @pre `unlock` was called
  void lock() GECOS_ACQUIRE() {
    mutex_.lock();
    holds_ = true;
  }

 private:
  friend class ConditionVariable;
  M& mutex_;
  bool holds_ = true;
};

/// Unlocks a mutex while this object lives, and then locks the mutex again. @pre the caller holds
/// the mutex
template <class M>
class GECOS_SCOPED_CAPABILITY MutexUnlock {
 public:
  explicit MutexUnlock(M& mutex) GECOS_RELEASE(mutex) : mutex_(mutex) { mutex_.unlock(); }
  ~MutexUnlock() GECOS_RELEASE() { mutex_.lock(); }
  MutexUnlock(const MutexUnlock&) = delete;
  MutexUnlock& operator=(const MutexUnlock&) = delete;

 private:
  M& mutex_;
};

/// A std::condition_variable for Mutex. (For FutexMutex use std::condition_variable_any.) The
/// calling thread holds the mutex before and after each wait, and during each call of the parameter
/// `done`. The function `done` must call `assert_held()` of the mutex in its first line.
class ConditionVariable {
 public:
  void notify_one() noexcept { changed_.notify_one(); }
  void notify_all() noexcept { changed_.notify_all(); }

  void wait(MutexLock<Mutex>& lock) {
    Native native(lock);
    changed_.wait(native.held);
  }
  template <class Done>
  void wait(MutexLock<Mutex>& lock, Done done) {
    Native native(lock);
    changed_.wait(native.held, done);
  }
  /// Waits for a notification until `deadline`. Returns false when the deadline passed before a
  /// notification.
  bool wait_until(MutexLock<Mutex>& lock, TimePoint deadline) {
    Native native(lock);
    return changed_.wait_until(native.held, deadline) == std::cv_status::no_timeout;
  }
  /// Waits until `done()` returns true or the deadline has passed. Returns the last result of
  /// `done()`.
  template <class Done>
  bool wait_until(MutexLock<Mutex>& lock, TimePoint deadline, Done done) {
    Native native(lock);
    return changed_.wait_until(native.held, deadline, done);
  }
  bool wait_for(MutexLock<Mutex>& lock, Duration length) {
    Native native(lock);
    return changed_.wait_for(native.held, length) == std::cv_status::no_timeout;
  }
  template <class Done>
  bool wait_for(MutexLock<Mutex>& lock, Duration length, Done done) {
    Native native(lock);
    return changed_.wait_for(native.held, length, done);
  }

 private:
  struct Native {
    explicit Native(MutexLock<Mutex>& lock) : held(lock.mutex_.mutex_, std::adopt_lock) {}
    ~Native() { held.release(); }  // the mutex stays locked: `lock` owns it
    Native(const Native&) = delete;
    Native& operator=(const Native&) = delete;
    std::unique_lock<std::mutex> held;
  };
  std::condition_variable changed_;
};

}  // namespace gecos
