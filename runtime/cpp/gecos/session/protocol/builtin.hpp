#pragma once

#include "gecos/base/ids.hpp"

namespace gecos::session {

/// Returns true for the codes 1 to 255. They belong to the built-in operations
/// (gecos::GecosObject), including operations that a later version adds.
constexpr bool is_builtin(FunctionCode code) { return number(code) <= 255; }

}  // namespace gecos::session
