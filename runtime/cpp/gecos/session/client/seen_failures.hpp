#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// Which failures of the commands with @on_new("blend") of one session the program has seen. When
/// such a command does not succeed, those that the program issues before it has seen the failure
/// are left out: the server leaves out the ones that are sent after a sent one, and this class
/// those after one that was not sent. Thread-safe, except where a function says more.
class SeenFailures {
 public:
  /// The place of a command among the commands of its session.
  enum class Place : std::uint64_t {};
  static Place of_sent(std::uint64_t counter) { return Place{counter * 2}; }
  /// `issued`: the number of commands that were sent before the one that was not sent.
  static Place of_unsent(std::uint64_t issued) { return Place{issued * 2 + 1}; }

  /// Notes that the program knows that the command at `place` did not succeed, or does not care.
  void saw(Place place) {
    const auto number = static_cast<std::uint64_t>(place);
    std::uint64_t before = seen_.load(std::memory_order_relaxed);
    while (before < number && !seen_.compare_exchange_weak(before, number)) {
    }
  }

  /// Returns whether the program has seen a failure since it issued the command of the last
  /// sent_anew(). The mutex of the CallSender must be held, also for sent_anew().
  bool begins_anew() const { return seen_.load(std::memory_order_relaxed) >= begun_; }
  /// Notes that the command with this counter was sent as one that begins anew.
  void sent_anew(std::uint64_t counter) { begun_ = static_cast<std::uint64_t>(of_sent(counter)); }

  /// Notes that a command was not sent because of `why`.
  void not_sent(Place place, std::string why) {
    const MutexLock lock(mutex_);
    if (!unseen()) unsent_ = {static_cast<std::uint64_t>(place), std::move(why)};
  }
  /// Returns why the first command was not sent whose failure the program has not seen; nullopt if
  /// there is none.
  std::optional<std::string> why_not_sent() const {
    const MutexLock lock(mutex_);
    if (!unseen()) return std::nullopt;
    return unsent_.why;
  }

 private:
  struct Unsent {
    std::uint64_t place = 0;
    std::string why;
  };
  bool unseen() const GECOS_REQUIRES(mutex_) {
    return unsent_.place > seen_.load(std::memory_order_relaxed);
  }

  std::atomic<std::uint64_t> seen_{0};  // orders no other memory
  std::uint64_t begun_ = 1;             // guarded by the mutex of the CallSender
  mutable Mutex mutex_;
  Unsent unsent_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
