#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"

namespace gecos::qos {

/// Decides when a session whose connection is degraded looks for another medium
/// (`on_degraded="failover"`), and when the program is told that the session keeps its medium. A
/// session that has a status must keep its medium, and looks for no other medium. Each degradation
/// is followed by exactly one report: the session has moved, or it stays. A session that stays
/// looks again every `between_searches` while it is degraded, but reports nothing more. Reads no
/// clock. Not thread-safe.
class FailoverPlan {
 public:
  static constexpr Duration between_searches = std::chrono::seconds(5);

  enum class Act : std::uint8_t {
    None,
    Search,  ///< look for another medium; then found_none(), moved() or dropped() must be called
    ReportStay,  ///< tell the program that the session stays, because it must
  };
  /// Must be called periodically. `must_stay`: the session must not move now.
  Act look(bool degraded, bool must_stay, TimePoint now);
  /// Must be called when no better medium was found. Returns whether the program must be told that
  /// the session stays on its medium.
  bool found_none(TimePoint now);
  /// Must be called when the session has moved to another medium.
  void moved() { *this = {}; }
  /// Must be called when the search found a medium, but the session does not use it, because the
  /// session must now keep its medium.
  void dropped() { searching_ = false; }

 private:
  bool searching_ = false;
  bool reported_ = false;  ///< this degradation was reported
  TimePoint next_{};       ///< the time of the next search
};

}  // namespace gecos::qos
