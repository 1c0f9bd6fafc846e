#pragma once

#include <atomic>
#include <cstdint>

#include "gecos/base/ids.hpp"
#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// The status (actor or master) under which a session issues its commands, and how many leases of
/// that status the program holds. Thread-safe.
class LeaseState {
 public:
  /// Returns the epoch for the next command; Epoch{} when the session has no status.
  Epoch epoch() const { return Epoch{epoch_.load(std::memory_order_relaxed)}; }
  /// Counts a new lease of the status with the epoch `epoch`. Returns the number of the status,
  /// which the caller passes to `released` and `lost`.
  std::uint64_t acquired(std::uint64_t epoch);
  /// Removes one lease of the status with the number `held` from the count. When the last lease of
  /// the newest status is removed, the session has no status any more.
  void released(std::uint64_t held);
  /// Returns true when the session has acquired a newer status than the one with the number `held`.
  bool lost(std::uint64_t held) const;
  /// Must be called when the server has given the status a new epoch: later commands are issued
  /// under `epoch`. Does nothing without a lease.
  void renewed(Epoch epoch);

 private:
  std::atomic<std::uint64_t> epoch_{0};  // orders no other memory
  mutable FutexMutex mutex_;
  /// How many statuses the session has acquired so far; also the number of the newest status.
  std::uint64_t statuses_ GECOS_GUARDED_BY(mutex_) = 0;
  /// Number of leases of the newest status that are not released yet.
  std::uint64_t leases_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace gecos::session
