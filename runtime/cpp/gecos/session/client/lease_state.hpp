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
  /// Counts a new lease of the status with the epoch `epoch`. Returns the argument for `released`.
  std::uint64_t acquired(std::uint64_t epoch);
  /// Removes one lease from the count. When the last lease of the newest status is removed, the
  /// session has no status any more.
  void released(std::uint64_t held);
  /// Returns whether the session has acquired another status since `held`.
  bool lost(std::uint64_t held) const;
  /// Must be called when the server has given the status a new epoch: later commands are issued
  /// under `epoch`. Does nothing without a lease.
  void renewed(Epoch epoch);

 private:
  std::atomic<std::uint64_t> epoch_{0};  // orders no other memory
  mutable FutexMutex mutex_;
  /// The number of statuses acquired so far; `leases_` counts the leases of the newest status.
  std::uint64_t statuses_ GECOS_GUARDED_BY(mutex_) = 0;
  /// Number of leases of the newest status that are not released yet.
  std::uint64_t leases_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace gecos::session
