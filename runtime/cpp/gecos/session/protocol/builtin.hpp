#pragma once

#include "gecos/base/ids.hpp"

namespace gecos::session {

/// Codes 1 to 255 are those of gecos::GecosObject, which every object answers, including those that
/// a later version adds to it.
constexpr bool is_builtin(FunctionCode code) { return number(code) <= 255; }

}  // namespace gecos::session
