// Owned and borrowed sequences of bytes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gecos {

using Bytes = std::vector<std::byte>;

/// Borrowed: the bytes must outlive the view.
using ByteView = std::span<const std::byte>;

}  // namespace gecos
