#include "gecos/qos/requested_quality.hpp"

#include <algorithm>

namespace gecos::qos {
namespace {

constexpr Duration century = std::chrono::hours(100 * 365 * 24);

/// Returns the shorter of two longest times. A `declared` time of zero sets no limit.
Duration shorter(Duration declared, Duration requested) {
  if (requested <= Duration{} || requested > century) return declared;
  return declared > Duration{} ? std::min(declared, requested) : requested;
}

}  // namespace

Quality stricter(const Quality& declared, const RequestedQuality& requested) {
  Quality terms = declared;
  terms.line = std::max(declared.line, requested.line);
  // BEST_EFFORT demands nothing, so a request for it never changes what is declared.
  if (requested.reliability == Reliability::Reliable) terms.reliability = Reliability::Reliable;
  terms.deadline = shorter(declared.deadline, requested.deadline);
  terms.lifespan = shorter(declared.lifespan, requested.lifespan);
  terms.liveliness = std::max(declared.liveliness, requested.liveliness);
  return terms;
}

}  // namespace gecos::qos
