#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "robcl/arm/configuration.hpp"

namespace devices {

/// Keeps, for each session, the configuration in which the next joint move of this session must
/// end. The configuration is forgotten when the object is stopped, and when the status under which
/// the session set the configuration ends. Thread-safe.
class NextConfiguration {
 public:
  /// A session, and the epoch of its status when it issued a command.
  struct Issuer {
    std::uint64_t session = 0, epoch = 0;
  };

  /// Sets the configuration for the next joint move of the session.
  void set(const Issuer& issuer, const robcl::arm::Configuration& wanted) {
    const gecos::MutexLock lock(mutex_);
    static_cast<void>(take_held(issuer));
    if (wanted_.size() == most_sessions) wanted_.pop_front();
    wanted_.emplace_back(issuer, wanted);
  }
  /// Sets the configuration `taken` again for the next joint move of the session. Must be called if
  /// take() returned `taken` for a joint move and the arm refused this move. Does nothing if the
  /// session has set another configuration since, or if the configurations of `most_sessions`
  /// sessions are kept.
  void give_back(const Issuer& issuer, const robcl::arm::Configuration& taken) {
    const gecos::MutexLock lock(mutex_);
    const auto of_session = [&](const auto& known) {
      return known.first.session == issuer.session;
    };
    if (std::ranges::any_of(wanted_, of_session) || wanted_.size() == most_sessions) return;
    wanted_.emplace_back(issuer, taken);
  }
  /// Returns the configuration for the joint move that the session has just requested, and forgets
  /// this configuration. Returns nullopt if the session has set no configuration.
  std::optional<robcl::arm::Configuration> take(const Issuer& issuer) {
    const gecos::MutexLock lock(mutex_);
    return take_held(issuer);
  }

 private:
  // The greatest number of sessions whose configuration is kept. If there are more sessions, the
  // oldest configuration is forgotten, because its session may never request a joint move.
  static constexpr std::size_t most_sessions = 64;

  std::optional<robcl::arm::Configuration> take_held(const Issuer& issuer) GECOS_REQUIRES(mutex_) {
    for (auto at = wanted_.begin(); at != wanted_.end(); ++at) {
      if (at->first.session != issuer.session) continue;
      const auto [set_by, found] = *at;
      wanted_.erase(at);
      if (set_by.epoch != issuer.epoch) return std::nullopt;
      return found;
    }
    return std::nullopt;
  }

  gecos::Mutex mutex_;
  std::deque<std::pair<Issuer, robcl::arm::Configuration>> wanted_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace devices
