#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"

namespace gecos::qos {

/// Decides when a session whose connection is degraded looks for another medium
/// (`on_degraded="failover"`), and when its program is told that the session stays where it is. A
/// session that must stay, because it has a status, looks for none. Each degradation is followed by
/// exactly one report: the session has moved, or it stays. A session that stays looks again every
/// `between_searches` while it is degraded, without another report. Reads no clock. Not
/// thread-safe.
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
  /// Must be called when the search found no medium. Returns whether to tell the program.
  bool found_none(TimePoint now);
  /// Must be called when the session has moved to another medium.
  void moved() { *this = {}; }
  /// Must be called when what the search found is not used, because the session must stay after
  /// all.
  void dropped() { searching_ = false; }

 private:
  bool searching_ = false;
  bool reported_ = false;  ///< this degradation was reported
  TimePoint next_{};       ///< the time of the next search
};

}  // namespace gecos::qos
