#include "gecos/qos/latency_sample.hpp"

#include <algorithm>

namespace gecos::qos {

LatencySample::Latency LatencySample::latency(TimePoint now) const {
  if (round_trips_.empty()) return {now - begun_, false};
  std::vector<Duration> sorted = round_trips_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return {*middle, true};
}

}  // namespace gecos::qos
