#include "gecos/base/suspension.hpp"

#include <atomic>
#include <optional>

namespace gecos {
namespace {

/// Returns the total time for which the machine was suspended since its start. Returns nothing when
/// this thread was interrupted between its readings of the two clocks.
std::optional<Duration> measured(const Clock& clock) {
  const TimePoint before = clock.now();
  const TimePoint since_boot = clock.since_boot();
  if (clock.now() - before > std::chrono::milliseconds(1)) return std::nullopt;
  return since_boot - before;
}

std::atomic<Duration::rep> noted{// protects no other data
                                 measured(SystemClock()).value_or(Duration::zero()).count()};

}  // namespace

Duration noted_suspension() { return Duration{noted.load(std::memory_order_relaxed)}; }

void note_suspension(const Clock& clock) {
  if (const auto total = measured(clock)) noted.store(total->count(), std::memory_order_relaxed);
}

}  // namespace gecos
