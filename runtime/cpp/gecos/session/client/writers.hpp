#pragma once

#include <atomic>
#include <cstdint>

#include "gecos/base/ids.hpp"
#include "gecos/session/client/lease_state.hpp"

namespace gecos::session {

/// The state that all inward streams of one session share. Thread-safe.
class Writers {
 public:
  /// `leases` must outlive this object.
  Writers(SessionId session, const LeaseState& leases) : session_(session), leases_(leases) {}

  SessionId session() const { return session_; }
  /// Returns the epoch for the next sample; Epoch{} when the session has no status.
  Epoch epoch() const { return leases_.epoch(); }
  /// Returns a new number, which identifies an inward stream of the session to the server.
  std::uint32_t new_id() { return ids_.fetch_add(1, std::memory_order_relaxed) + 1; }
  /// Counts a sample that the program has sent.
  void note_sample() { sent_.fetch_add(1, std::memory_order_relaxed); }
  /// Returns the number of samples that the program has sent.
  std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }

 private:
  const SessionId session_;
  const LeaseState& leases_;
  std::atomic<std::uint32_t> ids_{0};   // orders no other memory
  std::atomic<std::uint64_t> sent_{0};  // orders no other memory
};

}  // namespace gecos::session
