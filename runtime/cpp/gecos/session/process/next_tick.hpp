#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Says when the next tick of a target is due.
struct NextTick {
  NextTick(TimePoint due_at, Duration how_early = {}) : due(due_at), early(how_early) {}

  TimePoint due;
  /// How much earlier than `due` the tick may come, if another target ticks then. One wake-up of
  /// the thread then serves both.
  Duration early;
};

/// A target, as tick_due() sees it.
struct TickTimes {
  NextTick next{TimePoint{}};
  bool ticked = false;  ///< in the latest tick of the thread
};

/// Returns whether the targets that have ticked must tick earlier from now on, until their ticks
/// come together with those of the targets that cannot tick early. If all targets can tick early,
/// the first one keeps its times, and the others approach it; otherwise none would meet another.
template <class Target>
bool must_approach(const std::vector<Target>& targets) {
  const Target* first = nullptr;
  bool some_are_fixed = false;
  bool fixed_ticked = false;
  for (const Target& one : targets) {
    if (one.next.due == TimePoint::max()) continue;
    if (first == nullptr) first = &one;
    if (one.next.early != Duration{}) continue;
    some_are_fixed = true;
    fixed_ticked = fixed_ticked || one.ticked;
  }
  return some_are_fixed ? !fixed_ticked : first != nullptr && !first->ticked;
}

/// Calls `tick(i)`, which returns a NextTick, for each target `i` whose tick comes at `now`; with
/// `all`, for each target. Returns when the next tick is due. A Target is a TickTimes. A process
/// may have a thousand targets, whose ticks are due at different times.
template <class Target, class Tick>
TimePoint tick_due(std::vector<Target>& targets, TimePoint now, bool all, Tick tick) {
  const auto is_due = [&](const Target& one) { return one.next.due <= now; };
  if (all || std::any_of(targets.begin(), targets.end(), is_due)) {
    for (std::size_t at = 0; at < targets.size(); ++at) {
      Target& one = targets[at];
      one.ticked = all || one.next.due - one.next.early <= now;
      if (one.ticked) one.next = tick(at);
    }
    if (!all && must_approach(targets)) {
      for (Target& one : targets) {
        if (one.ticked) one.next.due -= one.next.early;
      }
    }
  }
  TimePoint next = TimePoint::max();
  for (const Target& one : targets) next = std::min(next, one.next.due);
  return next;
}

}  // namespace gecos::session
