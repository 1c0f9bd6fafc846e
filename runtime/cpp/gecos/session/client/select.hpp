#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Returns the addresses of the object `entry` that meet `asked`, best first; or a text with every
/// medium and each term that it violates. Only this function decides which medium suits which
/// client.
tl::expected<std::vector<std::string>, std::string> select(Runtime& runtime, const Entry& entry,
                                                           const qos::Quality& asked,
                                                           std::optional<media::Kind> only);

}  // namespace gecos::session
