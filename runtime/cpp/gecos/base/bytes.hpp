// Types for owned and for borrowed sequences of bytes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gecos {

using Bytes = std::vector<std::byte>;

/// A borrowed sequence of bytes. The bytes must outlive the view.
using ByteView = std::span<const std::byte>;

}  // namespace gecos
