#pragma once

#include <cstdint>
#include <string_view>

namespace gecos::access {

/// The rights of a client at an object; each status includes the ones before it.
enum class Status : std::uint8_t {
  Sensor,  ///< read; every client has it
  Actor,   ///< move and change; one client at a time unless shared by password
  Master,  ///< like actor, and everybody else's calls are refused
};
std::string_view to_string(Status status);

}  // namespace gecos::access
