#include "gecos/base/moment.hpp"

#include <time.h>

namespace gecos {
namespace {

std::int64_t nanoseconds_of(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

Moment Moment::now() {
  return {nanoseconds_of(CLOCK_MONOTONIC_COARSE), nanoseconds_of(CLOCK_REALTIME_COARSE)};
}

}  // namespace gecos
