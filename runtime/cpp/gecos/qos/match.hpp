#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/qos/quality.hpp"

/// Whether a line is as good as what is asked, and which of several is best. Pure.
namespace gecos::qos {

/// Promises of one medium, and measurements of it.
struct LineOffer {
  std::string name;            ///< name of its medium, for messages: "shm"
  bool between_hosts = false;  ///< packets leave the host, or could
  bool reliable = true;        ///< nothing is lost, by the medium or because the session repeats it
  bool real_time = true;       ///< no loss and no shared queue below the session
  bool reports_death = true;   ///< a peer's death is known at once, not only by its silence
  std::optional<Duration> latency{};  ///< measured p99 of a round trip, once it is measured
};

/// One term of the quality that a line does not meet.
struct Violation {
  std::string term;  ///< as in the interface: `class=HARD_REALTIME`
  std::string why;   ///< "lcm shares its queue with others and may lose packets"
};

/// What `offer` lacks; empty when it meets `asked`. What is not measured yet is not held against
/// it. HARD_REALTIME here speaks of the medium only; the waiting threads are another matter.
std::vector<Violation> violations(const Quality& asked, const LineOffer& offer);

/// Indices of the offers that meet `asked`, best first: static promises, then the lower measured
/// latency, then the order given.
std::vector<std::size_t> rank(const Quality& asked, std::span<const LineOffer> offers);

/// The best of the offers, or a text that lists every one of them with each term it violates.
tl::expected<std::size_t, std::string> choose(const Quality& asked,
                                              std::span<const LineOffer> offers);

}  // namespace gecos::qos
