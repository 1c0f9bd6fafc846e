#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"

namespace gecos::session {

/// Who reads a link. One thread at a time leads and completes everybody's commands; the others
/// follow: they sleep until the leader has something for them or leaves.
class Baton {
 public:
  bool try_take() { return !held_.exchange(true, std::memory_order_acquire); }
  /// Leaves it to a follower, if there is one.
  void drop();

  enum class Woken : std::uint8_t { Done, Poked, TimedOut };
  /// Sleeps until `done`, or poked (then look again and try to lead), or `deadline`. `subject` is
  /// what `poke` names; null for whoever wants to look at everything that arrives.
  Woken follow(const void* subject, FunctionRef<bool()> done, TimePoint deadline);

  /// Wakes those who wait for `subject`. Call it after what they wait for is published.
  void poke(const void* subject);
  void poke_all();

 private:
  struct Follower {
    const void* subject = nullptr;
    bool poked = false;
    std::condition_variable woken;
  };
  void poke_one();

  std::atomic<bool> held_{false};       // publishes the link's receiving side to the next leader
  std::atomic<int> follower_count_{0};  // publishes nothing: spares the lock when there is none
  std::mutex mutex_;
  std::vector<Follower*> followers_;
};

}  // namespace gecos::session
