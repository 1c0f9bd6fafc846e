#pragma once

#include <algorithm>
#include <chrono>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Returns how long to wait for a reply before a packet is sent again over a medium that loses
/// packets: 20, 40, 80, then always 160 ms. `sent`: how often the packet was sent so far.
constexpr Duration retry_after(int sent) {
  return std::chrono::milliseconds(20 << std::clamp(sent - 1, 0, 3));
}

}  // namespace gecos::session
