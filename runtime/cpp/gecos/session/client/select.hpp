#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/description.hpp"
#include "gecos/explanation.hpp"
#include "gecos/qos/match.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Returns what a session promises over a medium with these capabilities.
qos::LineCapabilities line_of(const media::Capabilities& capabilities);

/// Returns the quality that `asked` demands of a medium. A late packet does no harm in a simulated
/// device, so that soft real time is enough for it.
qos::Quality demanded_of(qos::Quality asked, bool simulated);

/// Returns the name of the medium of an address: "shm".
std::string medium_of(const std::string& address);

/// Returns what a session would promise at `address`, one of the addresses of `entry`. If this
/// program cannot reach the object there, returns the reason.
tl::expected<qos::LineCapabilities, std::string> line_to(Runtime& runtime, const Entry& entry,
                                                         const std::string& address);

/// Returns the operations and streams of `interface` whose own quality `line` does not meet.
/// `simulated`: whether the object is a simulated device.
std::vector<UnsuitedMember> unsuited_members(const InterfaceDescription& interface,
                                             const qos::LineCapabilities& line, bool simulated);

/// Returns the addresses of the object `entry` whose media meet the quality `asked`, best first. If
/// there is none, returns a text that says of each medium why it is not suitable. `only`: the only
/// medium to consider. No other function decides which medium a client uses.
tl::expected<std::vector<std::string>, std::string> select(Runtime& runtime, const Entry& entry,
                                                           const qos::Quality& asked,
                                                           std::optional<media::Kind> only);

}  // namespace gecos::session
