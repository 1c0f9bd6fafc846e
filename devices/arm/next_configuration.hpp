#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "robcl/arm/configuration.hpp"

namespace devices {

/// Keeps, for each session, the configuration in which its next joint move must end. Thread-safe.
class NextConfiguration {
 public:
  /// Sets the configuration for the next joint move of the session.
  void set(std::uint64_t session, const robcl::arm::Configuration& wanted) {
    const gecos::MutexLock lock(mutex_);
    static_cast<void>(take_held(session));
    if (wanted_.size() == most_sessions) wanted_.pop_front();
    wanted_.emplace_back(session, wanted);
  }
  /// Sets the configuration again, because the joint move for which it was taken was refused. Does
  /// nothing if the session has set another one since.
  void give_back(std::uint64_t session, const robcl::arm::Configuration& taken) {
    const gecos::MutexLock lock(mutex_);
    const auto of_session = [&](const auto& known) { return known.first == session; };
    if (std::ranges::any_of(wanted_, of_session) || wanted_.size() == most_sessions) return;
    wanted_.emplace_back(session, taken);
  }
  /// Returns the configuration for the joint move that the session has just requested, and forgets
  /// it. Returns nullopt if the session has set no configuration.
  std::optional<robcl::arm::Configuration> take(std::uint64_t session) {
    const gecos::MutexLock lock(mutex_);
    return take_held(session);
  }

 private:
  // The greatest number of sessions whose configuration is kept. If there are more sessions, the
  // oldest configuration is forgotten: its session may never move.
  static constexpr std::size_t most_sessions = 64;

  std::optional<robcl::arm::Configuration> take_held(std::uint64_t session) GECOS_REQUIRES(mutex_) {
    for (auto at = wanted_.begin(); at != wanted_.end(); ++at) {
      if (at->first != session) continue;
      const robcl::arm::Configuration found = at->second;
      wanted_.erase(at);
      return found;
    }
    return std::nullopt;
  }

  gecos::Mutex mutex_;
  std::deque<std::pair<std::uint64_t, robcl::arm::Configuration>> wanted_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace devices
