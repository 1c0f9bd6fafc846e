#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "gecos/audit/line.hpp"

namespace gecos::audit {

/// Counts events that one client repeats, so that a program that sends a thousand commands per
/// second adds two lines per second to the audit, and not a thousand. The first event gets a line
/// of its own. Equal events within the next second are only counted, and together get one more
/// line.
///
/// The caller passes the time. Only one thread at a time may use this class. `count` allocates and
/// formats nothing.
class Repeats {
 public:
  static constexpr std::int64_t window_ms = 1000;
  /// The number of kinds of events that are counted at the same time. Each event of a further kind
  /// gets a line of its own.
  static constexpr std::size_t most = 64;

  /// The members in which two events of one object must agree to count as equal.
  struct Key {
    std::uint64_t session = 0;
    std::uint64_t code = 0;
    std::uint8_t outcome = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };

  /// Counts the event and returns true, if an equal event had a line less than a second ago.
  /// Otherwise returns false: the caller then writes a line, and passes it to `begin`.
  bool count(const Key& key, std::uint64_t counter);
  /// Begins to count the events that are equal to the event of `line`.
  void begin(const Key& key, const Line& line);
  /// Returns a line for all events whose second is over and that were repeated.
  std::vector<Line> due(std::int64_t now);
  /// Returns the lines of all events that were repeated.
  std::vector<Line> all();

 private:
  struct Run {
    Key key;
    Line line;  ///< its `request` becomes that of the first repetition
  };
  std::vector<Run> runs_;
};

}  // namespace gecos::audit
