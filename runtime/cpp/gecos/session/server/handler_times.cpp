#include "gecos/session/server/handler_times.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace gecos::session {

/// The times of one octave, from 2^n to 2^(n+1) ns, have four buckets of the same width.
std::size_t HandlerTimes::bucket_of(Duration took) {
  const auto ns = static_cast<std::uint64_t>(std::max(took, Duration::zero()).count());
  if (ns >> first_octave == 0) return 0;
  const auto octave = static_cast<std::size_t>(std::bit_width(ns) - 1);
  const std::size_t quarter = (ns >> (octave - 2)) & 3;
  return std::min((octave - first_octave) * of_octave + quarter, of_octave * octaves - 1);
}

Duration HandlerTimes::end_of(std::size_t bucket) {
  const std::size_t octave = bucket / of_octave + first_octave;
  return Duration{static_cast<Duration::rep>((bucket % of_octave + 5) << (octave - 2))};
}

void HandlerTimes::add(Duration took, std::uint32_t weight) {
  buckets_[bucket_of(took)] += weight;
  count_ += weight;
  worst_ = std::max(worst_, took);
}

Duration HandlerTimes::quantile(double share) const {
  if (count_ == 0) return {};
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t passed = 0;
  for (std::size_t bucket = 0; bucket + 1 < buckets_.size(); ++bucket) {
    passed += buckets_[bucket];
    if (passed >= wanted) return std::min(end_of(bucket), worst_);
  }
  return worst_;
}

}  // namespace gecos::session
