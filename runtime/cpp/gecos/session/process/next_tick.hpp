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
  /// The tick may come earlier or later by this time, together with the tick of another target, so
  /// that the thread wakes once for both. If the ticks of a target come alone, they become earlier
  /// by `shift` until they meet those of another target. A tick may thus come up to twice `shift`
  /// early, and must then do its work.
  Duration shift;
};

/// What the functions below know of a target.
struct TickTimes {
  /// How often the ticks of a target may become earlier in a row, without meeting others: twice as
  /// often as a target needs whose shift is a tenth of its period.
  static constexpr int most_approaches = 20;

  NextTick next{TimePoint{}};
  bool ticked = false;  ///< in the latest tick_due() that called a target
  /// How often its ticks became earlier since they met those of another target.
  int approaches = 0;
};

/// Returns when the thread must wake: when the first tick is due, or when the second one is, if the
/// first one can wait for it.
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

/// Called after tick_due() has called some targets. If they can shift their ticks, and none of them
/// ticks at fixed times, makes their next ticks earlier, so that after some periods these come
/// together with ticks at fixed times. If all targets can shift their ticks, those of the first
/// target count as fixed; otherwise all would become earlier, and none would meet another.
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
/// session with a server of this process is newer than the server, and sends its heartbeat before
/// the server looks for it.
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
