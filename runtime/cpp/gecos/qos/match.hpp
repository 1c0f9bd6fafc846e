#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/qos/latency_sample.hpp"
#include "gecos/qos/quality.hpp"

/// Checks media against a required quality of service and selects the best medium. Pure functions.
namespace gecos::qos {

/// What a laboratory states about a medium, in place of the medium's own promise.
struct RealTimeStatement {
  bool real_time = false;  ///< whether HARD_REALTIME is possible over the medium
  std::string text;  ///< for example "[media.shm] in lab.toml:4 says that shm is not real-time"
};

/// The promises of one medium, and the latency that was measured over it.
struct LineCapabilities {
  std::string name;            ///< name of the medium for messages, for example "shm"
  bool between_hosts = false;  ///< packets may leave the host
  bool reliable = true;        ///< no call is lost, or the session retransmits each lost packet
  bool keeps_samples = true;   ///< no sample of a stream is lost on its way
  bool real_time = true;       ///< the medium loses no packet and shares no queue with others
  bool reports_death = true;   ///< the death of a peer is reported at once, not only noticed by its
                               ///< silence
  std::optional<LatencySample::Latency> latency{};  ///< nullopt before its measurement
  /// If set, decides in place of `real_time` whether HARD_REALTIME is possible over the medium. The
  /// order in which `rank` puts the media depends on `real_time` all the same.
  std::optional<RealTimeStatement> stated{};
};

/// One term of the required quality that a medium does not meet.
struct Violation {
  std::string term;  ///< as in the interface, for example `class=HARD_REALTIME`
  std::string why;  ///< for example "the medium lcm may lose packets, and nothing retransmits them"
  bool operator==(const Violation&) const = default;
};

/// Returns `duration` as users write it in an interface: "250us", "5ms", "1.2s".
std::string with_unit(Duration duration);

/// Returns the terms of `asked` that `line` does not meet for `traffic`; empty when it meets all of
/// them. A latency term counts as met until the latency has been measured. HARD_REALTIME is checked
/// only for the medium, not for the threads that wait for packets.
std::vector<Violation> violations(const Quality& asked, const LineCapabilities& line,
                                  Traffic traffic = Traffic::Calls);

/// Returns the indices of the elements of `lines` that meet `asked`, best first. The promises of
/// the media decide first, then the lower measured latency, then the order in `lines`.
std::vector<std::size_t> rank(const Quality& asked, std::span<const LineCapabilities> lines);

/// Returns the index of the best element of `lines`. If none meets `asked`, returns a text that
/// lists each element with the terms that it violates. A reason that holds for several elements is
/// listed once.
tl::expected<std::size_t, std::string> choose(const Quality& asked,
                                              std::span<const LineCapabilities> lines);

}  // namespace gecos::qos
