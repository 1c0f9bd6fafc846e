#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/qos/quality.hpp"

/// Checks media against a required quality and selects the best of them. Pure functions.
namespace gecos::qos {

/// What one medium promises, and what was measured over it.
struct LineCapabilities {
  std::string name;            ///< name of its medium, for messages: "shm"
  bool between_hosts = false;  ///< packets leave the host, or may leave it
  bool reliable = true;        ///< no packet is lost, or the session retransmits each lost packet
  bool real_time = true;       ///< no loss and no shared queue below the session
  bool reports_death = true;   ///< a peer's death is detected at once, not only by silence
  std::optional<Duration> latency{};  ///< 99th percentile of a round trip, once it is measured
};

/// One term of the required quality that a medium does not meet.
struct Violation {
  std::string term;  ///< as in the interface: `class=HARD_REALTIME`
  std::string why;   ///< "lcm shares its queue with others and may lose packets"
};

/// The terms of `asked` that `line` does not meet; empty when it meets all. A latency that is not
/// measured yet counts as met. HARD_REALTIME is checked for the medium only, not for the waiting
/// threads.
std::vector<Violation> violations(const Quality& asked, const LineCapabilities& line);

/// Indices of the lines that meet `asked`, best first. Static promises decide first, then the
/// lower measured latency, then the order of `lines`.
std::vector<std::size_t> rank(const Quality& asked, std::span<const LineCapabilities> lines);

/// The index of the best line, or a text that lists every line with each term that it violates.
tl::expected<std::size_t, std::string> choose(const Quality& asked,
                                              std::span<const LineCapabilities> lines);

}  // namespace gecos::qos
