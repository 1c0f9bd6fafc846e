#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Says when the next tick of a target is due.
struct NextTick {
  NextTick(TimePoint due_at, Duration its_shift = {}) : due(due_at), shift(its_shift) {}

  TimePoint due;
  /// A tick may come up to `shift` earlier or later than `due`, together with the tick of another
  /// target, so that the thread wakes once for both. While the ticks of this target come alone,
  /// each of them is due `shift` earlier, until it comes together with the tick of another target.
  /// So a tick may come up to twice `shift` too early, and must do its work even then.
  Duration shift;
};

/// The times of the ticks of one target, for the functions below.
struct TickTimes {
  /// The maximum number of successive ticks of a target that are due earlier (NextTick::shift). A
  /// target whose shift is a tenth of its period needs half as many until its ticks come together
  /// with those of another target.
  static constexpr int most_approaches = 20;

  NextTick next{TimePoint{}};
  bool ticked = false;  ///< the last tick_due() that called a target called this target
  /// How many ticks of this target were due earlier (NextTick::shift) since a tick of this target
  /// last came together with the tick of another target.
  int approaches = 0;
};

/// Returns the time at which the thread must wake: the time of the first tick or, if the first tick
/// can wait for the second one, the time of the second tick.
template <std::derived_from<TickTimes> Target>
TimePoint wake_at(const std::vector<Target>& targets) {
  NextTick first = TimePoint::max();
  TimePoint second = TimePoint::max();
  for (const Target& one : targets) {
    if (one.next.due < first.due) {
      second = std::exchange(first, one.next).due;
    } else {
      second = std::min(second, one.next.due);
    }
  }
  return second - first.shift <= first.due ? second : first.due;
}

/// Must be called after tick_due() has called some targets. Lets ticks that can be shifted approach
/// the ticks of the targets that tick at fixed times. If tick_due() has called no target with fixed
/// times, the next ticks of the called targets become due earlier by their `shift`. After some
/// periods they come together with ticks at fixed times. If all targets can shift their ticks, the
/// first target counts as the one with fixed times; otherwise the ticks of all targets would become
/// earlier and never come together.
template <std::derived_from<TickTimes> Target>
void approach_others(std::vector<Target>& targets) {
  const auto ticks = [](const Target& one) { return one.next.due != TimePoint::max(); };
  const auto is_fixed = [&](const Target& one) {
    return ticks(one) && one.next.shift == Duration{};
  };
  const auto first = std::ranges::find_if(targets, ticks);
  if (first == targets.end()) return;
  const bool some_are_fixed = std::ranges::any_of(targets, is_fixed);
  const bool met = std::ranges::any_of(targets, [&](const Target& one) {
    return one.ticked && (some_are_fixed ? is_fixed(one) : &one == &*first);
  });
  for (Target& one : targets) {
    if (!one.ticked) continue;
    if (met) {
      one.approaches = 0;
    } else if (one.approaches < TickTimes::most_approaches) {
      ++one.approaches;
      one.next.due -= one.next.shift;
    }
  }
}

/// Calls `tick(i)`, which returns a NextTick, for each target `i`. The newest target comes first: a
/// client's session with a server of this process is newer than the server, and so sends its
/// heartbeat before the server looks for this heartbeat.
template <std::derived_from<TickTimes> Target, class Tick>
void tick_all(std::vector<Target>& targets, Tick tick) {
  for (std::size_t at = targets.size(); at-- > 0;) targets[at].next = tick(at);
}

/// Like tick_all(), but only for the targets whose ticks come at the time `now`. A process may have
/// a thousand targets, whose ticks are due at different times.
template <std::derived_from<TickTimes> Target, class Tick>
void tick_due(std::vector<Target>& targets, TimePoint now, Tick tick) {
  if (now < wake_at(targets)) return;
  for (std::size_t at = targets.size(); at-- > 0;) {
    Target& one = targets[at];
    one.ticked = one.next.due - one.next.shift <= now;
    if (one.ticked) one.next = tick(at);
  }
  approach_others(targets);
}

}  // namespace gecos::session
