#pragma once

#include <algorithm>
#include <chrono>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// How long to wait for an answer after the `sent`th sending, over a medium that loses packets:
/// 20, 40, 80, then 160 ms.
constexpr Duration retry_after(int sent) {
  return std::chrono::milliseconds(20 << std::clamp(sent - 1, 0, 3));
}

}  // namespace gecos::session
