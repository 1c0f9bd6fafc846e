#pragma once

#include <cstdint>
#include <string_view>

namespace gecos::access {

/// The rights of a client at an object. Each status includes the rights of the statuses before it.
enum class Status : std::uint8_t {
  Sensor,  ///< may read; every client has this status
  Actor,   ///< may also move and change; held by one client, or by several that share a password
  Master,  ///< like Actor; in addition, the calls of all other clients are refused
};
std::string_view to_string(Status status);

}  // namespace gecos::access
