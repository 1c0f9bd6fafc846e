#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// Decides which thread reads a connection. One thread at a time is the leader: it reads the
/// packets and completes the commands of all threads. The other threads are followers: they sleep
/// until the leader notifies them or gives up the lead. While the leader sleeps until a packet
/// wakes it, another thread may read packets that were sent without a wake-up (media/quiet.hpp).
class LeaderLock {
 public:
  LeaderLock() { followers_.reserve(usual_followers); }

  bool try_take() { return change(State::Free, State::Held); }
  /// Must be called by the leader. Gives up the lead and wakes a follower, if there is one, so that
  /// the follower can become the leader.
  void drop();

  /// Called by the leader before it sleeps: another thread may then read in its place.
  void rest() { state_.store(State::Resting, std::memory_order_release); }
  /// Called by the leader when it is awake. Waits until no other thread reads in its place.
  void resume();
  /// Returns true when the leader sleeps; the calling thread then reads in its place until it calls
  /// `release`.
  bool borrow() { return change(State::Resting, State::Borrowed); }
  void release();

  enum class Woken : std::uint8_t { Done, Notified, TimedOut };
  /// Sleeps until `done()`, a notification, or `deadline`. After a notification, the caller must
  /// check `done()` again and try to become the leader. `subject`: the argument of `notify` that
  /// wakes this thread; null to be notified of every packet that arrives.
  Woken follow(const void* subject, FunctionRef<bool()> done, TimePoint deadline);

  /// Wakes the threads that wait for `subject`. Must be called after the event that these threads
  /// wait for is published.
  void notify(const void* subject);
  void notify_all();

 private:
  struct Follower {  // a sleeping thread; guarded by mutex_
    const void* subject = nullptr;
    bool notified = false;
    ConditionVariable woken;
  };
  /// Up to this number of threads can be followers at the same time without an allocation of
  /// memory. The number is high enough for readers at 1 kHz.
  static constexpr std::size_t usual_followers = 16;
  enum class State : std::uint8_t { Free, Held, Resting, Borrowed };
  bool change(State from, State to) {
    return state_.compare_exchange_strong(from, to, std::memory_order_acquire,
                                          std::memory_order_relaxed);
  }
  bool free() const { return state_.load(std::memory_order_seq_cst) == State::Free; }
  void notify_one();

  // `state_` orders memory: the next thread that reads the connection sees all that the previous
  // thread has written while it read the connection.
  std::atomic<State> state_{State::Free};
  std::atomic<int> follower_count_{0};  // 0: mutex_ need not be locked
  Mutex mutex_;
  std::vector<Follower*> followers_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
