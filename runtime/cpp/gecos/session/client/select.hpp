#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Returns the addresses of the object `entry` whose media meet the quality `asked`, best first. If
/// there is none, returns a text that says of each medium why it is not suitable. `only`: the only
/// medium to consider. No other function decides which medium a client uses.
tl::expected<std::vector<std::string>, std::string> select(Runtime& runtime, const Entry& entry,
                                                           const qos::Quality& asked,
                                                           std::optional<media::Kind> only);

}  // namespace gecos::session
