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
/// Events that a user who is not admitted can cause without end are counted in windows that grow
/// (Window::Growing): the lines after the first one count the events of 1, 2, 4, 8, 16 and 32 s,
/// and then of one minute each, until there was no such event for a minute.
///
/// The caller passes the time. Only one thread at a time may use this class. `count` allocates and
/// formats nothing.
class Repeats {
 public:
  static constexpr std::int64_t window_ms = 1000;
  static constexpr std::int64_t longest_window_ms = 60'000;
  enum class Window : std::uint8_t { OneSecond, Growing };
  /// The default for the constructor.
  static constexpr std::size_t most = 64;

  /// `most_kinds`: the number of different events whose repetitions are counted at the same time.
  /// Every other event gets a line of its own.
  explicit Repeats(std::size_t most_kinds = most) : most_(most_kinds) {}

  /// The members in which two events of one object must agree to count as equal.
  struct Key {
    std::uint64_t session = 0;
    std::uint64_t code = 0;
    std::uint8_t outcome = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };

  /// Counts the event and returns true if the window of an equal event, for which `begin` was
  /// called, is not over. Otherwise returns false; the caller must then write a line for the event
  /// and pass the line to `begin`.
  bool count(const Key& key, std::uint64_t counter);
  /// Begins to count the events that are equal to the event of `line`.
  void begin(const Key& key, const Line& line, Window window = Window::OneSecond);
  /// Returns a line with the count for each event that was repeated and whose window is over.
  std::vector<Line> due(std::int64_t now);
  /// Returns a line with the count for each event that was repeated, even if its window is not
  /// over.
  std::vector<Line> all();

 private:
  struct Run {
    Key key;
    Line line;  ///< its `request` becomes that of the first repetition
    Window window = Window::OneSecond;
    std::int64_t length = window_ms;  ///< of the window that began at the time of `line`
  };
  /// Adds the line of `run` to `lines` if there were repetitions. Returns whether `run` has ended.
  static bool end_window(Run& run, std::int64_t now, std::vector<Line>& lines);

  const std::size_t most_;
  std::vector<Run> runs_;
};

}  // namespace gecos::audit
