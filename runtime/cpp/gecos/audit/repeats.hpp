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
  /// The number of different events whose repetitions are counted at the same time. Every other
  /// event gets a line of its own.
  static constexpr std::size_t most = 64;

  /// The members in which two events of one object must agree to count as equal.
  struct Key {
    std::uint64_t session = 0;
    std::uint64_t code = 0;
    std::uint8_t outcome = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };

  /// Counts the event and returns true if `begin` was called for an equal event less than a second
  /// ago. Otherwise returns false; the caller must then write a line for the event and pass the
  /// line to `begin`.
  bool count(const Key& key, std::uint64_t counter);
  /// Begins to count the events that are equal to the event of `line`.
  void begin(const Key& key, const Line& line);
  /// Returns a line with the count for each event that was repeated and whose second is over.
  std::vector<Line> due(std::int64_t now);
  /// Returns a line with the count for each event that was repeated, even if its second is not
  /// over.
  std::vector<Line> all();

 private:
  struct Run {
    Key key;
    Line line;  ///< its `request` becomes that of the first repetition
  };
  std::vector<Run> runs_;
};

}  // namespace gecos::audit
