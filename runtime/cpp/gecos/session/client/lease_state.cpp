#include "gecos/session/client/lease_state.hpp"

namespace gecos::session {

std::uint64_t LeaseState::acquired(std::uint64_t epoch) {
  const MutexLock lock(mutex_);
  if (epoch_.exchange(epoch, std::memory_order_relaxed) != epoch) {
    ++statuses_;
    leases_ = 0;
  }
  ++leases_;
  return statuses_;
}

void LeaseState::released(std::uint64_t held) {
  const MutexLock lock(mutex_);
  if (held != statuses_ || --leases_ != 0) return;
  epoch_.store(0, std::memory_order_relaxed);
}

bool LeaseState::lost(std::uint64_t held) const {
  const MutexLock lock(mutex_);
  return held != statuses_;
}

void LeaseState::renewed(Epoch epoch) {
  const MutexLock lock(mutex_);
  // A reply that the server sent again may contain an older epoch than the present one.
  if (leases_ != 0 && epoch > this->epoch()) {
    epoch_.store(number(epoch), std::memory_order_relaxed);
  }
}

}  // namespace gecos::session
