// Owned and borrowed runs of bytes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gecos {

using Bytes = std::vector<std::byte>;

/// Borrows: whoever keeps one must know that the bytes outlive it.
using ByteView = std::span<const std::byte>;

}  // namespace gecos
