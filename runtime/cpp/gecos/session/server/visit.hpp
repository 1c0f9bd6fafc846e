#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <utility>

#include "gecos/access/access_policy.hpp"

namespace gecos::session {

/// Records whether the client of one session may do everything that the status of the client
/// allows, or is only a visitor (access/visitors.hpp). Thread-safe.
class Visit {
 public:
  /// Must be called once, when the session is opened. `visitor`: the user of the client if it is a
  /// visitor; otherwise no value.
  void open(std::optional<access::UserAtHost> visitor) {
    if (visitor) who_ = *std::move(visitor);
    state_.store(visitor ? State::Visitor : State::Full, std::memory_order_release);
  }
  /// Returns the user of a visitor; null if the client is not a visitor or the session is not open.
  const access::UserAtHost* visitor() const {
    return state_.load(std::memory_order_acquire) == State::Visitor ? &who_ : nullptr;
  }
  /// Returns whether the session is open and its client is not a visitor.
  bool is_full() const { return state_.load(std::memory_order_acquire) == State::Full; }
  /// Must be called when a list of the lab file now admits the client, which was a visitor so far.
  void widen() { state_.store(State::Full, std::memory_order_release); }

 private:
  enum class State : std::uint8_t { NotOpen, Full, Visitor };

  access::UserAtHost who_;                    // constant once `state_` is Visitor
  std::atomic<State> state_{State::NotOpen};  // publishes `who_` to all threads
};

}  // namespace gecos::session
