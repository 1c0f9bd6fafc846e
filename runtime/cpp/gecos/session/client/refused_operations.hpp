#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/qos/match.hpp"
#include "gecos/qos/requested_quality.hpp"
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

/// The operations and streams that a client must not use in one session. The client refuses them
/// before anything is sent. Both the getter and the stream of an attribute have the code of the
/// attribute; the stream may be refused alone.
class RefusedOperations {
 public:
  /// `differing`: the codes of the operations that server and client define differently, sorted.
  explicit RefusedOperations(std::vector<FunctionCode> differing)
      : differing_(std::move(differing)) {}

  /// Also refuses the operations and streams of `wanted` whose `@qos`, together with `requested`,
  /// demands more than `line`, the promises of the medium. `simulated`: whether the object is a
  /// simulated device.
  void check_quality(const InterfaceDescription& wanted, const qos::LineCapabilities& line,
                     bool simulated, const qos::RequestedQuality& requested = {});

  /// Returns why the operation or stream `name` is refused; nullopt if it may be used. `traffic`:
  /// Calls for an operation, Samples for a stream.
  std::optional<Failure> why(FunctionCode code, std::string_view name, const Welcome& server,
                             qos::Traffic traffic = qos::Traffic::Calls) const;

 private:
  struct Unsuited {
    FunctionCode code{};
    std::string terms;  ///< for example "media=shm: lcm is not one of these media"
  };
  const std::vector<FunctionCode> differing_;
  std::vector<Unsuited> calls_;    ///< sorted by code
  std::vector<Unsuited> streams_;  ///< sorted by code; has an entry for each code in `calls_`, too
  std::string medium_;
};

}  // namespace gecos::session
