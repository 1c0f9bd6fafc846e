#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

/// Which failures of the commands with @on_new("blend") of one session the program has seen. When
/// such a command does not succeed, those that the program issues before it has seen the failure
/// are left out: the server leaves out the ones that are issued after a sent one, and this class
/// those after one that was not sent. Thread-safe, except where a function says more.
class SeenFailures {
 public:
  /// A command among those of its session that were sent, or among those that were not.
  struct Place {
    bool sent = true;
    std::uint64_t number = 0;  ///< of a sent command its counter
  };

  /// Notes that the program knows that the command at `place` did not succeed.
  void saw(const Place& place) { raise(place.sent ? seen_ : seen_unsent_, place.number); }
  /// Notes that the outcome of the command at `place` does not matter to the program.
  void ignores(const Place& place) { raise(place.sent ? ignored_ : seen_unsent_, place.number); }
  /// Notes that the program has acquired the status at `epoch`, with which the server begins a
  /// chain. An epoch that was noted already, of a status that the program had, changes nothing.
  void acquired(std::uint64_t epoch) {
    if (acquired_.exchange(epoch) == epoch) return;
    raise(seen_unsent_, unsent_so_far_.load(std::memory_order_relaxed));
  }

  /// Returns the flags of the next Call packet with an actor command. The mutex of the CallSender
  /// must be held, also for `sent`.
  std::int8_t flags() const {
    if (ignored_.load(std::memory_order_relaxed) >= begun_) return stands_alone;
    return seen_.load(std::memory_order_relaxed) >= begun_ ? begins_anew : std::int8_t{0};
  }
  /// Notes that the command with this counter was sent with `flags`.
  void sent(std::uint64_t counter, std::int8_t flags) {
    if (flags != 0) begun_ = counter;
  }

  /// Notes that a command was not sent because of `why`, and returns its place.
  Place not_sent(std::string why) {
    const MutexLock lock(mutex_);
    const std::uint64_t number = unsent_so_far_.fetch_add(1, std::memory_order_relaxed) + 1;
    if (!unseen()) unsent_ = {number, std::move(why)};
    return {false, number};
  }
  /// Returns why the first command was not sent whose failure the program has not seen; nullopt if
  /// there is none.
  std::optional<std::string> why_not_sent() const {
    const auto seen = seen_unsent_.load(std::memory_order_relaxed);
    if (unsent_so_far_.load(std::memory_order_relaxed) <= seen) return std::nullopt;
    const MutexLock lock(mutex_);
    if (!unseen()) return std::nullopt;
    return unsent_.why;
  }

 private:
  struct Unsent {
    std::uint64_t number = 0;
    std::string why;
  };
  static void raise(std::atomic<std::uint64_t>& to, std::uint64_t number) {
    std::uint64_t before = to.load(std::memory_order_relaxed);
    while (before < number && !to.compare_exchange_weak(before, number)) {
    }
  }
  bool unseen() const GECOS_REQUIRES(mutex_) {
    return unsent_.number > seen_unsent_.load(std::memory_order_relaxed);
  }

  // These numbers order no other memory.
  std::atomic<std::uint64_t> seen_{0};
  std::atomic<std::uint64_t> ignored_{0};
  std::atomic<std::uint64_t> seen_unsent_{0};
  std::atomic<std::uint64_t> unsent_so_far_{0};
  std::atomic<std::uint64_t> acquired_{0};
  std::uint64_t begun_ = 1;  // guarded by the mutex of the CallSender
  mutable Mutex mutex_;
  Unsent unsent_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
