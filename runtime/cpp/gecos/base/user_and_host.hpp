#pragma once

#include <cstdint>
#include <string>

namespace gecos {

/// Returns the name of the user `uid`, or "uid 1234" of a user without a name.
std::string user_name(std::uint32_t uid);

/// Returns the name of this host, or "?" when the kernel does not tell it.
std::string host_name();

}  // namespace gecos
