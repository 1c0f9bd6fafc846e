#include "gecos/base/clock.hpp"

#include <time.h>

#include <cassert>

#include "gecos/base/clock_difference.hpp"
#include "gecos/base/moment.hpp"

namespace gecos {

TimePoint SystemClock::now() const { return std::chrono::steady_clock::now(); }

TimePoint SystemClock::since_boot() const {
  timespec passed{};
  ::clock_gettime(CLOCK_BOOTTIME, &passed);
  return TimePoint{std::chrono::seconds(passed.tv_sec) + std::chrono::nanoseconds(passed.tv_nsec)};
}

Duration SystemClock::unix_time() const {
  return std::chrono::system_clock::now().time_since_epoch();
}

TimeByBoth SystemClock::by_both() const {
  static thread_local constinit ClockDifference known;
  TimeByBoth now;
  for (int tries = 0; tries < 3; ++tries) {
    const Moment moment = Moment::now();
    const TimePoint boot = since_boot();
    if (!known.at(moment)) {
      now = {unix_time(), since_boot()};
      const Duration took = now.since_boot - boot;
      if (!known.remember(moment, now.unix_time - boot.time_since_epoch(), took)) continue;
    }
    return {boot.time_since_epoch() + *known.at(moment), boot};
  }
  return now;
}

TimePoint deadline_after(Duration patience) {
  const TimePoint now = SystemClock().now();
  return patience < TimePoint::max() - now ? now + patience : TimePoint::max();
}

FakeClock::FakeClock(TimePoint start, Duration unix_start)
    : start_(start), unix_start_(unix_start) {}

TimePoint FakeClock::now() const { return start_ + Duration{passed_.load()}; }

Duration FakeClock::unix_time() const { return unix_start_ + Duration{passed_.load()}; }

void FakeClock::advance(Duration step) {
  assert(step >= Duration::zero());
  passed_.fetch_add(step.count());
}

}  // namespace gecos
