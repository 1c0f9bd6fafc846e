#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace gecos::session {

/// Says whether the maintenance thread rests from one heartbeat of a session to the next. It rests
/// while no call is open and none was sent since its last tick. A client that has called since then
/// probably calls again soon, and that call should not have to wake the thread.
///
/// The maintenance thread calls `tick` and `take_tick_request`. The caller of `tick` and
/// `call_sent` holds one mutex; the other functions need none. The atomics order no other memory.
class IdleRest {
 public:
  /// Must be called at each tick of the session. `issued`: how many calls were sent so far; `open`:
  /// how many of them are open. Returns whether the thread rests until the next heartbeat.
  bool tick(std::uint64_t issued, std::size_t open) {
    const bool called = std::exchange(issued_, issued) != issued;
    const bool rests = open == 0 && !called;
    rests_.store(rests, std::memory_order_relaxed);
    return rests;
  }
  /// Must be called when a call was sent. Returns whether the thread must be woken: `tick` is then
  /// due at once.
  bool call_sent() {
    if (!rests_.exchange(false, std::memory_order_relaxed)) return false;
    tick_requested_.store(true, std::memory_order_relaxed);
    return true;
  }
  bool rests() const { return rests_.load(std::memory_order_relaxed); }
  /// Returns whether a call has ended the rest since this function was called last.
  bool take_tick_request() {
    return tick_requested_.load(std::memory_order_relaxed) &&
           tick_requested_.exchange(false, std::memory_order_relaxed);
  }

 private:
  std::uint64_t issued_ = 0;  ///< at the last tick
  std::atomic<bool> rests_{false};
  std::atomic<bool> tick_requested_{false};
};

}  // namespace gecos::session
