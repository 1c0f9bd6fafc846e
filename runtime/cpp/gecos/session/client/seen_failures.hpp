#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/session/protocol/chain_report.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

/// Records which failures of the commands with @on_new("blend") of one session the program has
/// seen. After a failure, the commands that the program issues before it has seen the failure are
/// not carried out. If the failed command was sent, the server refuses these commands; if the
/// failed command was not sent, this class does. Thread-safe, except where a function says
/// otherwise.
class SeenFailures {
 public:
  using Known = ChainReport::Known;
  /// Identifies a command of the session by a number. The commands that were sent and those that
  /// were not sent are numbered separately.
  struct Place {
    bool sent = true;
    std::uint64_t number = 0;  ///< for a sent command, its counter in the session
  };

  /// Notes what the program knows of the end of the command at `place`.
  void knows(const Place& place, Known known) {
    const MutexLock lock(mutex_);
    if (!place.sent) {
      // An earlier failure can be the reason for which a command was not sent. A program that
      // detaches this command has not necessarily seen the earlier failure.
      if (known == Known::Detached && place.number != unsent_.number) return;
      return raise(seen_unsent_, place.number);
    }
    if (unreported_.size() == most_unreported) unreported_.erase(unreported_.begin());
    const ChainReport::Entry entry{place.number, known};
    if (std::ranges::find(unreported_, entry) == unreported_.end()) unreported_.push_back(entry);
    any_unreported_.store(true, std::memory_order_relaxed);
  }
  /// Notes that the program has stopped the object, so that failures of earlier commands no longer
  /// matter.
  void begins_alone() {
    alone_.store(true, std::memory_order_relaxed);
    raise(seen_unsent_, unsent_so_far_.load(std::memory_order_relaxed));
  }
  /// Notes that the program has acquired the status with the epoch `epoch`. Failures under an
  /// earlier status no longer matter then. Does nothing if the status with this epoch was noted
  /// before.
  void acquired(std::uint64_t epoch) {
    if (acquired_.exchange(epoch) == epoch) return;
    raise(seen_unsent_, unsent_so_far_.load(std::memory_order_relaxed));
  }

  /// What the next Call packet with an actor command reports to the server.
  struct Says {
    std::int8_t flags = 0;  ///< 0, `reports` or `stands_alone`
    ChainReport report;     ///< empty unless the flags are `reports`
  };
  Says next() const {
    if (alone_.load(std::memory_order_relaxed)) return {stands_alone, {}};
    if (!any_unreported_.load(std::memory_order_relaxed)) return {};
    const MutexLock lock(mutex_);
    const std::size_t count = std::min(unreported_.size(), ChainReport::most);
    return {reports,
            {{unreported_.begin(), unreported_.begin() + static_cast<std::ptrdiff_t>(count)}}};
  }
  /// Notes that a command was sent, and that `said` was reported with it.
  void sent(const Says& said) {
    if (said.flags == 0) return;
    if (said.flags == stands_alone) alone_.store(false, std::memory_order_relaxed);
    const MutexLock lock(mutex_);
    for (const ChainReport::Entry& entry : said.report.entries) std::erase(unreported_, entry);
    any_unreported_.store(!unreported_.empty(), std::memory_order_relaxed);
  }

  /// Notes that a command was not sent because of `why`. Returns the place of this command.
  Place not_sent(std::string why) {
    const MutexLock lock(mutex_);
    const std::uint64_t number = unsent_so_far_.fetch_add(1, std::memory_order_relaxed) + 1;
    if (!unseen()) unsent_ = {number, std::move(why)};
    return {false, number};
  }
  /// If a command was not sent and the program has not seen this failure, returns why the command
  /// was not sent; otherwise nullopt. If there are several such commands, returns the reason of the
  /// first one.
  std::optional<std::string> why_not_sent() const {
    const auto seen = seen_unsent_.load(std::memory_order_relaxed);
    if (unsent_so_far_.load(std::memory_order_relaxed) <= seen) return std::nullopt;
    const MutexLock lock(mutex_);
    if (!unseen()) return std::nullopt;
    return unsent_.why;
  }

 private:
  static constexpr std::size_t most_unreported = 1024;
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

  // The atomics order no other memory.
  std::atomic<bool> alone_{false};
  std::atomic<bool> any_unreported_{false};
  std::atomic<std::uint64_t> seen_unsent_{0};
  std::atomic<std::uint64_t> unsent_so_far_{0};
  std::atomic<std::uint64_t> acquired_{0};
  mutable Mutex mutex_;
  std::vector<ChainReport::Entry> unreported_ GECOS_GUARDED_BY(mutex_);
  Unsent unsent_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
