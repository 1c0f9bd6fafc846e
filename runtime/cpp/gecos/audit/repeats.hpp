#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/audit/line.hpp"

namespace gecos::audit {

/// Counts events that one client repeats, so that a program that sends a thousand commands per
/// second adds two lines per second to the audit, instead of a thousand. The first event gets a
/// line of its own. Equal events within the next second are only counted, and together get one more
/// line.
///
/// Events that a user who is not admitted can cause without end are counted in windows that grow
/// (Window::Growing; SharedLines uses them): the lines after the first one count the events of 1,
/// 2, 4, 8, 16 and 32 s, and then of one minute each, until no such event has occurred for a
/// minute.
///
/// The caller passes the time. Only one thread at a time may use this class. `count` allocates and
/// formats nothing.
class Repeats {
 public:
  static constexpr std::int64_t window_ms = 1000;
  static constexpr std::int64_t longest_window_ms = 60'000;
  enum class Window : std::uint8_t { OneSecond, Growing };
  /// The default of `most_kinds`, an argument of the constructor.
  static constexpr std::size_t most = 64;

  /// `most_kinds`: the number of different events whose repetitions are counted at the same time.
  /// If there are more, every further event gets a line of its own.
  explicit Repeats(std::size_t most_kinds = most) : most_(most_kinds) {}

  /// The members of an event that decide whether two events are equal.
  struct Key {
    std::uint64_t session = 0;
    std::uint64_t code = 0;
    std::uint8_t outcome = 0;
    std::string text{};
    friend bool operator==(const Key&, const Key&) = default;
  };

  /// Counts the event and returns true if `begin` was called for an equal event whose window is not
  /// over. Otherwise returns false; the caller must then write a line for the event and pass the
  /// line to `begin`.
  bool count(const Key& key, std::uint64_t counter);
  /// From now on, counts the events with the key `key`. `line`: the line of the first of these
  /// events.
  void begin(const Key& key, const Line& line, Window window = Window::OneSecond);
  /// Returns a line with the count for each event that was repeated and whose window is over.
  std::vector<Line> due(std::int64_t now);
  /// Returns a line with the count for each event that was repeated, even if its window is not
  /// over, and forgets all events.
  std::vector<Line> all(std::int64_t now);
  /// Returns how many different events are counted now.
  std::size_t kinds() const { return keys_.size(); }

 private:
  struct Run {
    Line line;  ///< after a repetition, `request` is that of the first repetition
    Window window = Window::OneSecond;
    std::int64_t length = window_ms;  ///< in ms, of the window that began at the time of `line`
    /// Returns the time at which `due` must check this event again.
    std::int64_t due() const;
  };
  /// Ends a window of the repeated event `run`: adds a line with the count to `lines` if the event
  /// was repeated. Returns whether the event need not be counted any longer.
  static bool end_window(Run& run, std::int64_t now, std::vector<Line>& lines);
  void note_times(const Run& run);

  const std::size_t most_;
  std::vector<Key> keys_;  ///< kept apart from `runs_`, so that `count` searches little memory
  std::vector<Run> runs_;  ///< `runs_[i]` is the run of `keys_[i]`
  /// No window ends before this time.
  std::int64_t next_due_ = std::numeric_limits<std::int64_t>::max();
  /// The time at which the newest window began. If the present time is earlier, the clock was set
  /// back.
  std::int64_t newest_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace gecos::audit
