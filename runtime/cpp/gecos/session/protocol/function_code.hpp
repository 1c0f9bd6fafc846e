#pragma once

#include <string_view>

#include "gecos/base/ids.hpp"

namespace gecos::session {

/// Code of an operation that has no `@id`: FNV-1a of its scoped name, "gecos::Broker::lookup".
constexpr FunctionCode function_code(std::string_view scoped_name) {
  std::uint32_t value = 0x811c9dc5;
  for (const char letter : scoped_name) {
    value = (value ^ static_cast<unsigned char>(letter)) * 0x01000193;
  }
  return FunctionCode{value};
}

/// Codes of gecos::GecosObject, the operations that every object answers.
enum class BuiltIn : std::uint32_t {
  Holders = 1,
  Stop = 2,
  Ping = 3,
  Describe = 4,
  Acquire = 5,
  Release = 6,
  Subscribe = 7,
  Unsubscribe = 8,
  Outcome = 9,
};
inline constexpr std::uint32_t last_builtin_code = 255;

}  // namespace gecos::session
